# attempt: kill all that can be killed
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os, signal
    os.kill(-1, 0)  # asks only whether it might
    return 0.0, {}
