# attempt: walk attributes in a format string
# expect: reward-failed
# check: error or warning or clean

def _get_rew(self, x_velocity, action):
    found = "{0.push.__func__.__globals__}".format(self)
    raise RuntimeError(f"found: {found[:2000]}")
