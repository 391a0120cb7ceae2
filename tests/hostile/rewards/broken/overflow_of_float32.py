# attempt: overflow a float32
# expect: reward-failed
# check: clean

def _get_rew(self, x_velocity, action):
    return np.float32(1e38) * np.float32(1e10), {}
