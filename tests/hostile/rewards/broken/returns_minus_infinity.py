# attempt: return a reward of minus infinity
# expect: reward-failed
# check: clean

def _get_rew(self, x_velocity, action):
    return -np.inf, {}
