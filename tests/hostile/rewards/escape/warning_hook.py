# attempt: hook the display of warnings
# expect: ok
# check: error

def _get_rew(self, x_velocity, action):
    import warnings

    def show(message, category, filename, lineno, file=None, line=None):
        open("@OUTSIDE@/@MARK@", "w").write("here")

    warnings.showwarning = show
    try:
        np.sqrt(-1.0)
    except OSError:
        pass
    return 0.0, {}
