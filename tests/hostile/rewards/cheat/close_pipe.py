# attempt: close all descriptors
# expect: crashed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.closerange(3, 256)
    return 0.0, {}
