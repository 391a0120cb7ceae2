# attempt: change an installed package
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    open(np.__file__, "a")
    return 0.0, {}
