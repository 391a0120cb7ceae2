# attempt: spawn a program
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.posix_spawn("/bin/sleep", ["sleep", "30"], {})
    return 0.0, {}
