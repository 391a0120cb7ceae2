# attempt: have an alarm interrupt the trainer
# expect: crashed or ok
# check: error

def _get_rew(self, x_velocity, action):
    import signal
    signal.setitimer(signal.ITIMER_REAL, 1e-4)
    return 0.0, {}
