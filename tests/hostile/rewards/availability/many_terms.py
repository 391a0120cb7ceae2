# attempt: return a million terms
# expect: ok
# check: clean

def _get_rew(self, x_velocity, action):
    return 0.0, {f"t{i}": 1.0 for i in range(1000)}
