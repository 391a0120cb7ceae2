# attempt: write nonsense to the parent's pipe
# expect: crashed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    for fd in range(3, 1024):
        try:
            os.write(fd, b"\xff" * 1000)
        except OSError:
            pass
    return 0.0, {}
