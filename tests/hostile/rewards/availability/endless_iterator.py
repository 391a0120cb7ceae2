# attempt: add up a series that never ends
# expect: timed-out
# check: clean

def _get_rew(self, x_velocity, action):
    import itertools
    return float(sum(itertools.count())), {}
