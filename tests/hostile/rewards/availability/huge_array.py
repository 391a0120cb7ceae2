# attempt: ask for a terabyte
# expect: out-of-memory
# check: clean

def _get_rew(self, x_velocity, action):
    return float(np.ones(10**11).sum()), {}
