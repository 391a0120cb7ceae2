# attempt: empty a file that may be read, by opening it
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.open("@READABLE@/readable.txt", os.O_RDONLY | os.O_TRUNC)
    return 0.0, {}
