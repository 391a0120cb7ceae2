# attempt: make a folder
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.makedirs("@OUTSIDE@/@MARK@/deep")
    return 0.0, {}
