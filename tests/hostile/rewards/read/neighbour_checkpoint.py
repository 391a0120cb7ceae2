# attempt: load another candidate's checkpoint, replay and all
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    with np.load("@NEIGHBOUR@/arrays-0.npz") as held:
        raise RuntimeError(f"loot: {sorted(held)!r}")
