# attempt: kill the parent
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os, signal
    os.kill(@PARENT@, signal.SIGKILL)
    return 0.0, {}
