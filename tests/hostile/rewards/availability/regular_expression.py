# attempt: use an expression that backtracks for ever
# expect: timed-out
# check: error

def _get_rew(self, x_velocity, action):
    import re
    re.match("(a+)+$", "a" * 64 + "b")
    return 0.0, {}
