# attempt: return nothing
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    reward = float(x_velocity)
