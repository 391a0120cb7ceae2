# attempt: kill itself
# expect: crashed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.kill(os.getpid(), 9)
