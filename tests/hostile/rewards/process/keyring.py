# attempt: read the user's keys from the kernel
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes
    if ctypes.CDLL(None).syscall(250, 0, -4, 0, 0, 0) < 0:
        raise PermissionError
    return 0.0, {}
