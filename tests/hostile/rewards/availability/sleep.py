# attempt: sleep for an hour
# expect: timed-out
# check: error

def _get_rew(self, x_velocity, action):
    import time
    time.sleep(3600)
    return 0.0, {}
