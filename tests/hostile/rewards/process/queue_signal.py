# attempt: queue a signal to the parent
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes
    if ctypes.CDLL(None).sigqueue(@PARENT@, 9, None):
        raise PermissionError
    return 0.0, {}
