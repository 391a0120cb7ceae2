# attempt: open a socket by the numbers of the x32 calling convention
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes
    if ctypes.CDLL(None).syscall(0x40000000 + 41, 2, 1, 0) < 0:
        raise PermissionError
    return 0.0, {}
