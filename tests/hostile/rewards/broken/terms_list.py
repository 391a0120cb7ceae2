# attempt: return terms as a list
# expect: reward-failed
# check: clean or error

def _get_rew(self, x_velocity, action):
    return float(x_velocity), [1.0]
