# attempt: run a file as a program
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import runpy
    loot = runpy.run_path("@SECRET@")
    raise RuntimeError(f"loot: {loot!r}")
