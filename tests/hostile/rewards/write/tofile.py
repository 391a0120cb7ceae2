# attempt: leave a file through ndarray.tofile
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    np.zeros(3).tofile("@OUTSIDE@/@MARK@")
    return 0.0, {}
