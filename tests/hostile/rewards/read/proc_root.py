# attempt: go round by /proc/self/root
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    loot = open("/proc/self/root@SECRET@").read()
    raise RuntimeError(f"loot: {loot!r}")
