# attempt: raise BaseException
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    raise BaseException("nobody catches this")
