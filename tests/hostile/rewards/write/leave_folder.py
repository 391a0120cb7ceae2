# attempt: change the working folder and write there
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.chdir("@OUTSIDE@")
    open("@MARK@", "w").write("here")
    return 0.0, {}
