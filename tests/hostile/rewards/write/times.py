# attempt: change a file's times
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.utime("@LEDGER@", (0, 0))
    return 0.0, {}
