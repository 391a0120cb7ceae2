# attempt: loop for ever
# expect: timed-out
# check: error

def _get_rew(self, x_velocity, action):
    while True:
        x_velocity += 1
