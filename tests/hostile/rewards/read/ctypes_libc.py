# attempt: read a file through the C library
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes
    libc = ctypes.CDLL(None)
    fd = libc.open(b"@SECRET@", 0)
    if fd < 0:
        raise PermissionError
    buffer = ctypes.create_string_buffer(1000)
    libc.read(fd, buffer, 1000)
    loot = buffer.value
    raise RuntimeError(f"loot: {loot!r}")
