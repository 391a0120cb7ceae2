# attempt: write a gigabyte to standard output
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import sys
    for _ in range(1000):
        sys.stdout.write("x" * 1_000_000)
    return 0.0, {}
