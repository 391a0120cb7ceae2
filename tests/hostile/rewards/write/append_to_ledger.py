# attempt: append to the ledger
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    open("@LEDGER@", "ab").write(b"damage")
    return 0.0, {}
