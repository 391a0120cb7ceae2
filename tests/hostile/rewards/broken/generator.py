# attempt: yields in place of returning
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    yield float(x_velocity), {}
