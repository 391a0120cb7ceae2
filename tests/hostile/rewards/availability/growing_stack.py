# attempt: take memory as a stack, which the limit of data does not count
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import mmap
    page = mmap.mmap(-1, 20_000_000, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS | 0x100)
    return 0.0, {}
