# attempt: leave the process group
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.setsid()
    return 0.0, {}
