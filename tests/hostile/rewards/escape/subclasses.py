# attempt: walk the subclasses of object to a file type
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    classes = ().__class__.__base__.__subclasses__()
    loaders = [c for c in classes if c.__name__ in ("FileLoader", "FileIO", "_wrap_close")]
    loot = [c for c in loaders]
    loot = loaders[0].get_data(loaders[0], "@SECRET@")
    raise RuntimeError(f"loot: {loot!r}")
