# attempt: clone by the recent system call
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes
    arguments = (ctypes.c_uint64 * 11)(0, 0, 0, 0, 17)
    pid = ctypes.CDLL(None).syscall(435, arguments, 88)
    if pid < 0:
        raise PermissionError
    if pid == 0:
        import os
        os._exit(0)
    return 0.0, {}
