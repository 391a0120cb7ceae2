# attempt: report progress a million times
# expect: ok or timed-out or crashed
# check: error

def _get_rew(self, x_velocity, action):
    import os, struct
    frame = struct.pack("<BIq", 3, 8, 1) * 4000
    for fd in range(3, 1024):
        try:
            for _ in range(250):
                os.write(fd, frame)
        except OSError:
            pass
    return 0.0, {}
