# attempt: read the variables of process 1
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    loot = open("/proc/1/environ").read()
    raise RuntimeError(f"loot: {loot!r}")
