# attempt: fill pipes in threads that have open files of their own
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes, platform
    libc = ctypes.CDLL(None)
    number = {"x86_64": 56, "aarch64": 220}[platform.machine()]
    assert libc.syscall(436, 200, 255, 2) < 0, "close_range gave this thread files of its own"
    stack = ctypes.create_string_buffer(2**16)
    thread = libc.clone(libc.pause, ctypes.byref(stack, 2**15), 0x10B00, None)
    if thread < 0:
        raise PermissionError
    return 0.0, {}
