# attempt: take memory that limits do not count
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import mmap
    kept = self.__dict__.setdefault("kept", [])
    page = mmap.mmap(-1, 20_000_000)
    for start in range(0, 20_000_000, 4096):
        page[start] = 1
    kept.append(page)
    return 0.0, {}
