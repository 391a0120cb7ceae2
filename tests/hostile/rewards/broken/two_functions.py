# attempt: defines the function twice
# expect: ok
# check: error

def _get_rew(self, x_velocity, action):
    return 0.0, {}


def _get_rew(self, x_velocity, action):
    return float(x_velocity), {}
