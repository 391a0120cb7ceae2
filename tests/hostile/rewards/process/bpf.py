# attempt: load a program into the kernel
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes
    attributes = ctypes.create_string_buffer(128)
    if ctypes.CDLL(None).syscall(321, 0, attributes, 128) < 0:
        raise PermissionError
    return 0.0, {}
