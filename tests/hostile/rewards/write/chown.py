# attempt: give the ledger to somebody else
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.chown("@LEDGER@", 12345, 12345)
    return 0.0, {}
