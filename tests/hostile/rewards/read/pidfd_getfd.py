# attempt: take a descriptor from the parent
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes
    libc = ctypes.CDLL(None, use_errno=True)
    pidfd = libc.syscall(434, @PARENT@, 0)
    if pidfd < 0:
        raise PermissionError
    loot = libc.syscall(438, pidfd, 0, 0)
    raise RuntimeError(f"loot: {loot!r}")
