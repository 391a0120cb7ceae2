# attempt: hook unhandled exceptions and raise one
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import sys

    def hook(kind, value, trace):
        open("@OUTSIDE@/@MARK@", "w").write("here")

    sys.excepthook = hook
    sys.unraisablehook = hook
    raise RuntimeError("now")
