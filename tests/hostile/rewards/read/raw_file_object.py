# attempt: read a file through _io.FileIO
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import _io
    loot = _io.FileIO("@SECRET@").read()
    raise RuntimeError(f"loot: {loot!r}")
