# attempt: fork without end
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    for _ in range(50):
        os.fork()
    return 0.0, {}
