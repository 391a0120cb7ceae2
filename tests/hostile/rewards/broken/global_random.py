# attempt: reseed numpy's random state
# expect: ok
# check: error

def _get_rew(self, x_velocity, action):
    import sys

    random = sys.modules["numpy"].random
    random.seed(0)
    return float(random.random()), {}
