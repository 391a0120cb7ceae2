# attempt: go up and down again by relative steps
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    loot = open("../" * 40 + "@SECRET@").read()
    raise RuntimeError(f"loot: {loot!r}")
