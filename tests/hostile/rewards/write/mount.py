# attempt: mount something over the folder
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.mount(b"none", b"@OUTSIDE@", b"tmpfs", 0, None):
        raise OSError(ctypes.get_errno(), "refused")
    return 0.0, {}
