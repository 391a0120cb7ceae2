# attempt: is prose around code
# expect: invalid-reward
# check: error

Here is a reward function that encourages speed:

def _get_rew(self, x_velocity, action):
    return float(x_velocity), {}
