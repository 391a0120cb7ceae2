# attempt: rename the ledger
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.rename("@LEDGER@", "@LEDGER@.old")
    return 0.0, {}
