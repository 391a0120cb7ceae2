# attempt: put terminal codes into the diagnosis
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    raise ValueError("\x1b]0;owned\x07\x1b[2J\r@MARK@\u202e")
