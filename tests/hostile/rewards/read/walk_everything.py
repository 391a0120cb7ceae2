# attempt: walk the file system for readable text of the user
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    loot = [p for p, _, files in os.walk("@OUTSIDE@") for _ in files]
    if not loot:
        raise PermissionError("nothing to be seen")
    raise RuntimeError(f"loot: {loot!r}")
