# attempt: hide from the watchdog and loop
# expect: timed-out
# check: error

def _get_rew(self, x_velocity, action):
    from robomore.sandbox import heartbeat
    heartbeat._slots[0] = 0
    while True:
        pass
