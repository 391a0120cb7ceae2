# attempt: return a number alone
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    return float(x_velocity)
