# attempt: read whatever descriptors were inherited
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    found = []
    for fd in range(3, 256):
        try:
            found.append((fd, os.pread(fd, 1000, 0)))
        except OSError:
            pass
    raise RuntimeError(f"found: {found}")
