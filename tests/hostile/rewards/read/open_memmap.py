# attempt: map a file through np.lib.format.open_memmap
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import numpy.lib.format as format

    loot = format.open_memmap("@OUTSIDE@/secret.npy")
    raise RuntimeError(f"loot: {loot!r}")
