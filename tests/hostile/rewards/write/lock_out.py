# attempt: take everybody's rights to the ledger
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.chmod("@LEDGER@", 0)
    return 0.0, {}
