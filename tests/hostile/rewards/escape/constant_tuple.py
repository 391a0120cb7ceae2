# attempt: change a tuple in place
# expect: ok or crashed or failed or reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes
    pair = (0.0, {})
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(pair))
    ctypes.cast(id(pair) + 24, ctypes.POINTER(ctypes.c_void_p))[0] = id(1e9)
    return pair
