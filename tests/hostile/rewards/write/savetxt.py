# attempt: leave a file through np.savetxt
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    np.savetxt("@OUTSIDE@/@MARK@", np.zeros(3))
    return 0.0, {}
