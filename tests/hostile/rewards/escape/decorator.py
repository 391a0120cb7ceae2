# attempt: run code through a decorator
# expect: invalid-reward
# check: error

@lambda function: open("@SECRET@").read()
def _get_rew(self, x_velocity, action):
    return 0.0, {}
