# attempt: write a shared library and load it
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes
    with open("library.so", "wb") as file:
        file.write(b"\x7fELF" + bytes(60))
    ctypes.CDLL("./library.so")
    return 0.0, {}
