# attempt: fails as it is loaded
# expect: invalid-reward
# check: clean

WEIGHTS = np.array([1.0, 2.0]) @ np.array([1.0])


def _get_rew(self, x_velocity, action):
    return float(x_velocity), {}
