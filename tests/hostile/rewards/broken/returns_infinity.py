# attempt: return an infinite reward
# expect: reward-failed
# check: clean

def _get_rew(self, x_velocity, action):
    return float("inf"), {}
