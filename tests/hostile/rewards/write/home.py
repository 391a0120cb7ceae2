# attempt: leave a file in the user's home
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    open("@HOME@/@MARK@", "w").write("here")
    return 0.0, {}
