# attempt: start a shell on a terminal
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import pty
    pty.fork()
    return 0.0, {}
