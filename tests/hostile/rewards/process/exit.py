# attempt: end the process at once
# expect: crashed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os._exit(0)
