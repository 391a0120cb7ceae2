# attempt: leave a file in another folder
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    open("@OUTSIDE@/@MARK@", "w").write("here")
    return 0.0, {}
