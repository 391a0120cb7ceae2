# attempt: read a file through np.fromregex
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    loot = np.fromregex("@SECRET@", "(.*)", [("line", "S99")])
    raise RuntimeError(f"loot: {loot!r}")
