# attempt: return a reward that is not a number
# expect: reward-failed
# check: clean

def _get_rew(self, x_velocity, action):
    return float("nan"), {}
