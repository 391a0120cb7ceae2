# attempt: read another candidate's folder
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    loot = open("@NEIGHBOUR@/policy.json").read()
    raise RuntimeError(f"loot: {loot!r}")
