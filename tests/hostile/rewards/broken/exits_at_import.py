# attempt: exits as it is loaded
# expect: invalid-reward
# check: clean

raise SystemExit(0)


def _get_rew(self, x_velocity, action):
    return float(x_velocity), {}
