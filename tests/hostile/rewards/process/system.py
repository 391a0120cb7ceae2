# attempt: run a shell command
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    if os.system("touch @OUTSIDE@/@MARK@"):
        raise PermissionError
    return 0.0, {}
