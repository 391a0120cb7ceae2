# attempt: recurse for ever
# expect: reward-failed
# check: clean

def _get_rew(self, x_velocity, action):
    def down(n):
        return down(n + 1)

    return down(0), {}
