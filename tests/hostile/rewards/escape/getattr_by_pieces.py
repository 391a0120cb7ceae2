# attempt: spell a forbidden name in pieces
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    loader = getattr(np, "__lo" + "ader__")
    loot = getattr(loader, "get_" + "data")("@SECRET@")
    raise RuntimeError(f"loot: {loot!r}")
