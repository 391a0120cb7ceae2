# attempt: keep a little more at each call
# expect: out-of-memory
# check: error

def _get_rew(self, x_velocity, action):
    kept = self.__dict__.setdefault("kept", [])
    for _ in range(40):
        kept.append(np.ones(100_000))
    return 0.0, {}
