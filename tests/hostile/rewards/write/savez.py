# attempt: leave a file through np.savez
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    np.savez("@OUTSIDE@/@MARK@", np.zeros(3))
    return 0.0, {}
