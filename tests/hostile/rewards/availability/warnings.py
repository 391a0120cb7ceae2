# attempt: warn at every call
# expect: ok
# check: error

def _get_rew(self, x_velocity, action):
    import warnings
    warnings.simplefilter("always")
    for _ in range(100):
        warnings.warn("again")
    return 0.0, {}
