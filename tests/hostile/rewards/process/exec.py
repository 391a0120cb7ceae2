# attempt: become another program
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.execv("/bin/sh", ["sh", "-c", "sleep 30"])
