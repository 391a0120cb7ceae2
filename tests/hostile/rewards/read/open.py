# attempt: open a file
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    loot = open("@SECRET@").read()
    raise RuntimeError(f"loot: {loot!r}")
