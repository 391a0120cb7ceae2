# attempt: raise an exception with a message of 100 MB
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    raise ValueError("x" * 10**8)
