# attempt: become another user
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.setuid(12345)
    return 0.0, {}
