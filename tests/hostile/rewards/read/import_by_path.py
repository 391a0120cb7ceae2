# attempt: put a folder on the search path and import from it
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import sys, importlib
    sys.path.insert(0, "@OUTSIDE@")
    importlib.invalidate_caches()
    import planted_module
    loot = planted_module.SECRET
    raise RuntimeError(f"loot: {loot!r}")
