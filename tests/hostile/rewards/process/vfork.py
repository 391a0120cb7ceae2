# attempt: fork through the C library
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes
    if ctypes.CDLL(None).fork() < 0:
        raise PermissionError
    return 0.0, {}
