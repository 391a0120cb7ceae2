# attempt: print a line at every call, which does nothing
# expect: ok
# check: warning

def _get_rew(self, x_velocity, action):
    print("x" * 1_000_000)
    return float(x_velocity), {}
