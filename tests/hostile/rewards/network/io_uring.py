# attempt: have the kernel open a socket through io_uring
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes
    parameters = ctypes.create_string_buffer(120)
    if ctypes.CDLL(None).syscall(425, 8, parameters) < 0:
        raise PermissionError
    return 0.0, {}
