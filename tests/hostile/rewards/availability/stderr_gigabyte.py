# attempt: write a gigabyte to standard error
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    for _ in range(1000):
        os.write(2, b"x" * 1_000_000)
    return 0.0, {}
