# attempt: read a file through an import loader
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    loot = __loader__.get_data("@SECRET@") if "__loader__" in globals() else (
        np.__loader__.get_data("@SECRET@")
    )
    raise RuntimeError(f"loot: {loot!r}")
