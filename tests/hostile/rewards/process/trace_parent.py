# attempt: trace the parent
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes
    if ctypes.CDLL(None).ptrace(16, @PARENT@, 0, 0) < 0:
        raise PermissionError
    return 0.0, {}
