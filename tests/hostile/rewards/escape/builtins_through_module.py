# attempt: take builtins from numpy and open a file
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    loot = np.__builtins__["open"]("@SECRET@").read()
    raise RuntimeError(f"loot: {loot!r}")
