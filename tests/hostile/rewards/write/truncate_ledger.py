# attempt: empty the ledger by name
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.truncate("@LEDGER@", 0)
    return 0.0, {}
