# attempt: enter namespaces of its own to gain privileges
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes
    if ctypes.CDLL(None).unshare(0x10000000 | 0x00020000):
        raise PermissionError
    return 0.0, {}
