# attempt: leave bytecode in an installed package
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    open(os.path.join(os.path.dirname(np.__file__), "__pycache__", "@MARK@.pyc"), "wb").write(b"x")
    return 0.0, {}
