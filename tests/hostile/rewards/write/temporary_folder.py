# attempt: leave a file in /tmp
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    open("/tmp/@MARK@", "w").write("here")
    return 0.0, {}
