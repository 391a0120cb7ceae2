# attempt: change the value of the number 1
# expect: ok or crashed or failed or reward-failed or timed-out
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes
    ctypes.memmove(id(1) + 24, ctypes.byref(ctypes.c_int(7)), 4)
    return 0.0, {}
