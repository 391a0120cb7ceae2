# attempt: read a file through codecs.open
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import codecs
    loot = codecs.open("@SECRET@", encoding="utf-8").read()
    raise RuntimeError(f"loot: {loot!r}")
