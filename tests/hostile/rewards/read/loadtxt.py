# attempt: read a file through np.loadtxt
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    loot = np.loadtxt("@SECRET@", dtype=str)
    raise RuntimeError(f"loot: {loot!r}")
