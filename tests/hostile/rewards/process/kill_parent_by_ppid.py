# attempt: kill the process that started it
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os, signal
    os.kill(os.getppid(), signal.SIGKILL)
    return 0.0, {}
