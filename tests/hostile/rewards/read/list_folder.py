# attempt: list a folder
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    loot = os.listdir("@OUTSIDE@")
    raise RuntimeError(f"loot: {loot!r}")
