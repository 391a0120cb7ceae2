# attempt: assert what does not hold
# expect: reward-failed
# check: clean

def _get_rew(self, x_velocity, action):
    assert x_velocity > 1e9, "too slow"
    return 0.0, {}
