# attempt: change the action that was applied
# expect: ok
# check: error or warning or clean

def _get_rew(self, x_velocity, action):
    action[:] = 1000.0
    return float(x_velocity), {}
