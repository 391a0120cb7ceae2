# attempt: divide by zero
# expect: reward-failed
# check: clean

def _get_rew(self, x_velocity, action):
    return x_velocity / 0, {}
