# attempt: map a file through mmap
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import mmap, os
    loot = mmap.mmap(os.open("@SECRET@", os.O_RDONLY), 0, prot=mmap.PROT_READ)[:]
    raise RuntimeError(f"loot: {loot!r}")
