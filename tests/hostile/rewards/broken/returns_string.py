# attempt: return a string
# expect: reward-failed
# check: clean or error

def _get_rew(self, x_velocity, action):
    return "1.0", {}
