# attempt: map a file through np.memmap
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    loot = bytes(np.memmap("@SECRET@", dtype=np.uint8, mode="r"))
    raise RuntimeError(f"loot: {loot!r}")
