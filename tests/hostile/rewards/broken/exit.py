# attempt: call sys.exit
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import sys
    sys.exit(0)
