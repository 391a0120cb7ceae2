# attempt: read a variable through the C library
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes
    getenv = ctypes.CDLL(None).getenv
    getenv.restype = ctypes.c_char_p
    loot = getenv(b"@VARIABLE@")
    if loot is None:
        raise KeyError
    raise RuntimeError(f"loot: {loot!r}")
