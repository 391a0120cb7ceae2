# attempt: watch other processes through performance counters
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes
    attributes = ctypes.create_string_buffer(128)
    number = 298 if ctypes.sizeof(ctypes.c_void_p) == 8 else 241
    if ctypes.CDLL(None).syscall(number, attributes, -1, 0, -1, 0) < 0:
        raise PermissionError
    return 0.0, {}
