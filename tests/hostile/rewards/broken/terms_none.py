# attempt: return no terms
# expect: reward-failed
# check: clean or error

def _get_rew(self, x_velocity, action):
    return float(x_velocity), None
