# attempt: copy a file into the own folder
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import shutil
    loot = open(shutil.copyfile("@SECRET@", "mine")).read()
    raise RuntimeError(f"loot: {loot!r}")
