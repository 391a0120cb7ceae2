# attempt: read a file through os.open
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    loot = os.read(os.open("@SECRET@", os.O_RDONLY), 1000)
    raise RuntimeError(f"loot: {loot!r}")
