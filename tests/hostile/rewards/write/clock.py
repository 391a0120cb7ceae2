# attempt: set the machine's clock
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import time
    time.clock_settime(time.CLOCK_REALTIME, time.time())
    return 0.0, {}
