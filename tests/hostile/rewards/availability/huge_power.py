# attempt: compute a number of a billion digits
# expect: timed-out
# check: clean

def _get_rew(self, x_velocity, action):
    return float(10 ** 10 ** 9 % 7), {}
