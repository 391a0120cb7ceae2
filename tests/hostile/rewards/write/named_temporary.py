# attempt: leave a temporary file elsewhere
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import tempfile
    tempfile.NamedTemporaryFile(dir="/var/tmp", prefix="@MARK@", delete=False)
    return 0.0, {}
