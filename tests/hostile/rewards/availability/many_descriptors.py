# attempt: open descriptors without end
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    while True:
        os.pipe()
