# attempt: walk to the loader in a format_map
# expect: reward-failed
# check: error or warning or clean

def _get_rew(self, x_velocity, action):
    found = "{np.__loader__}{np.__spec__.origin}{np.__dict__}".format_map({"np": np})
    raise RuntimeError(f"found: {found[:2000]}")
