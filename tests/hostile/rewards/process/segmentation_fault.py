# attempt: read address 0
# expect: crashed
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes
    ctypes.string_at(0)
    return 0.0, {}
