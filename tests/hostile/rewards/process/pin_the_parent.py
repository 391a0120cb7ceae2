# attempt: pin the parent to one processor
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.sched_setaffinity(@PARENT@, os.sched_getaffinity(@PARENT@))
    return 0.0, {}
