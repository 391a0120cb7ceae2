# attempt: reseed numpy's random state
# expect: ok
# check: error

def _get_rew(self, x_velocity, action):
    np.random.seed(0)
    return float(np.random.random()), {}
