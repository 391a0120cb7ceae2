# attempt: read lines through fileinput
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import fileinput
    loot = list(fileinput.input("@SECRET@"))
    raise RuntimeError(f"loot: {loot!r}")
