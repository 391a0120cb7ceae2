# attempt: takes one argument too many
# expect: invalid-reward
# check: error

def _get_rew(self, x_velocity, action, weight):
    return weight * x_velocity, {}
