# attempt: signal a thread of the parent
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes
    if ctypes.CDLL(None).tgkill(@PARENT@, @PARENT@, 9):
        raise PermissionError
    return 0.0, {}
