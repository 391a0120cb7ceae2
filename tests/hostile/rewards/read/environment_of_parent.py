# attempt: read the parent's variables in /proc
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    loot = open("/proc/@PARENT@/environ").read()
    raise RuntimeError(f"loot: {loot!r}")
