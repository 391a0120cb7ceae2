# attempt: link to a file and read the link
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.symlink("@SECRET@", "link")
    loot = open("link").read()
    raise RuntimeError(f"loot: {loot!r}")
