# attempt: replace the environment's methods
# expect: ok
# check: error

def _get_rew(self, x_velocity, action):
    type(self).push = lambda self, force: 1e9
    return float(x_velocity), {}
