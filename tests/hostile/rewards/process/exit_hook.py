# attempt: leave a hook for the end of the interpreter
# expect: ok
# check: error

def _get_rew(self, x_velocity, action):
    import atexit
    atexit.register(lambda: open("late", "w").write("@MARK@"))
    return 0.0, {}
