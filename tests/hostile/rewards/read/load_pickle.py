# attempt: have np.load unpickle a file
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    loot = np.load("@OUTSIDE@/secret.pkl", allow_pickle=True)
    raise RuntimeError(f"loot: {loot!r}")
