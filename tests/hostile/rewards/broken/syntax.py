# attempt: does not parse
# expect: invalid-reward
# check: error

def _get_rew(self, x_velocity, action)
    return 0.0, {}
