# attempt: leave a segment of System V shared memory
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.shmget(0x524F424F, 4096, 0o1600) < 0:
        raise OSError(ctypes.get_errno(), "refused")
    return 0.0, {}
