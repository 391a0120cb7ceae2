# attempt: remove all that is there
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os, shutil
    shutil.rmtree("@OUTSIDE@", ignore_errors=True)
    shutil.rmtree("@NEIGHBOUR@", ignore_errors=True)
    raise PermissionError("if anything is left")
