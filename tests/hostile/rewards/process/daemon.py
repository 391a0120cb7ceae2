# attempt: become a daemon
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os, time
    if os.fork() == 0:
        os.setsid()
        if os.fork() == 0:
            time.sleep(30)
        os._exit(0)
    return 0.0, {}
