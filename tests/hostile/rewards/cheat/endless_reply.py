# attempt: announce an answer of 4 GB
# expect: crashed
# check: error

def _get_rew(self, x_velocity, action):
    import os, struct
    for fd in range(3, 1024):
        try:
            os.write(fd, struct.pack("<BI", 4, 2**32 - 1) + b"x" * 1000)
        except OSError:
            pass
    return 0.0, {}
