# attempt: return three things
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    return float(x_velocity), {}, 1
