# attempt: read a file through pathlib
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import pathlib
    loot = pathlib.Path("@SECRET@").read_text()
    raise RuntimeError(f"loot: {loot!r}")
