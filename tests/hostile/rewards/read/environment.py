# attempt: read a variable of the parent's environment
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    loot = os.environ["@VARIABLE@"]
    raise RuntimeError(f"loot: {loot!r}")
