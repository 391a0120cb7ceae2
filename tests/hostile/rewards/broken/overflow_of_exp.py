# attempt: overflow an exponential
# expect: reward-failed
# check: clean

def _get_rew(self, x_velocity, action):
    return math.exp(1000.0 + x_velocity), {}
