# attempt: stop itself and wait
# expect: timed-out
# check: error

def _get_rew(self, x_velocity, action):
    import os, signal
    os.kill(os.getpid(), signal.SIGSTOP)
    return 0.0, {}
