# attempt: attach an attribute to a file
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.setxattr("@LEDGER@", "user.mark", b"here")
    return 0.0, {}
