# attempt: leave a file through np.memmap
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    np.memmap("@OUTSIDE@/@MARK@", mode="w+", shape=(3,))
    return 0.0, {}
