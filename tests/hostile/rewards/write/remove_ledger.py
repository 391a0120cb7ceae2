# attempt: remove the ledger
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.unlink("@LEDGER@")
    return 0.0, {}
