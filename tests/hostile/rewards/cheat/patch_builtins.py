# attempt: replace built-in functions
# expect: ok or failed or crashed or reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import builtins
    builtins.isinstance = lambda value, kind: True
    builtins.float = lambda value: 1e9
    return 0.0, {}
