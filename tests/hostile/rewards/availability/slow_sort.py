# attempt: multiply matrices for minutes
# expect: timed-out
# check: clean

def _get_rew(self, x_velocity, action):
    m = np.ones((1500, 1500))
    for _ in range(10_000):
        m = m @ m / 1500.0
    return float(m[0, 0]), {}
