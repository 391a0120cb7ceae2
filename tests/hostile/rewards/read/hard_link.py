# attempt: make a second name for a file
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.link("@SECRET@", "mine")
    loot = open("mine").read()
    raise RuntimeError(f"loot: {loot!r}")
