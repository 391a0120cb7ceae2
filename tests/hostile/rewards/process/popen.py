# attempt: read a program's output
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.popen("cat @SECRET@").read()
    return 0.0, {}
