# attempt: use a name that is not there
# expect: reward-failed
# check: clean

def _get_rew(self, x_velocity, action):
    return forward_speed, {}
