# attempt: abort the process
# expect: crashed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.abort()
