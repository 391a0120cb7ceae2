# attempt: loop for ever as it is loaded
# expect: timed-out
# check: error

while True:
    pass


def _get_rew(self, x_velocity, action):
    return 0.0, {}
