# attempt: open a path without reading, then read through /proc
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    fd = os.open("@SECRET@", os.O_PATH)
    loot = open(f"/proc/self/fd/{fd}").read()
    raise RuntimeError(f"loot: {loot!r}")
