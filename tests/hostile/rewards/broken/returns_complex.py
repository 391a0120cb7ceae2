# attempt: return a complex number
# expect: reward-failed
# check: clean

def _get_rew(self, x_velocity, action):
    return complex(x_velocity, 1.0), {}
