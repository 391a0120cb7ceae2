# attempt: read a file through np.fromfile
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    loot = np.fromfile("@SECRET@", dtype=np.uint8).tobytes()
    raise RuntimeError(f"loot: {loot!r}")
