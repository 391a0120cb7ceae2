# attempt: run code in an annotation, which nobody evaluates
# expect: ok
# check: error

def _get_rew(self: open("@SECRET@"), x_velocity, action):
    return 0.0, {}
