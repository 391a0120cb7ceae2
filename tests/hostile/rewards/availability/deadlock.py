# attempt: wait for a lock that nobody opens
# expect: timed-out
# check: error

def _get_rew(self, x_velocity, action):
    import threading
    lock = threading.Lock()
    lock.acquire()
    lock.acquire()
    return 0.0, {}
