# attempt: keep a memory in a list
# expect: ok
# check: clean or warning

MEMORY = []


def _get_rew(self, x_velocity, action):
    MEMORY.append(float(x_velocity))
    return float(np.mean(MEMORY)), {}
