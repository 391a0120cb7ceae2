# attempt: keep a count in a global
# expect: ok
# check: clean

COUNT = 0


def _get_rew(self, x_velocity, action):
    global COUNT
    COUNT += 1
    return float(COUNT), {}
