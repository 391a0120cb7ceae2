# attempt: search all objects for the secret
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import gc
    names = ("@VARIABLE@", b"@VARIABLE@")
    loot = [o for o in gc.get_objects() if isinstance(o, dict) and any(n in o for n in names)]
    if not loot:
        raise LookupError("not in this process")
    raise RuntimeError(f"loot: {loot!r}")
