# attempt: read a file through np.genfromtxt
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    loot = np.genfromtxt("@SECRET@", dtype=str)
    raise RuntimeError(f"loot: {loot!r}")
