# attempt: raise KeyboardInterrupt
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    raise KeyboardInterrupt
