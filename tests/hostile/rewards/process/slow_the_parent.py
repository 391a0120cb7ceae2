# attempt: lower the parent's priority
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.setpriority(os.PRIO_PROCESS, @PARENT@, 0)
    return 0.0, {}
