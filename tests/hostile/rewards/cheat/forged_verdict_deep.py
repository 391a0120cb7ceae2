# attempt: write a fault that is nested too deeply
# expect: crashed
# check: error

def _get_rew(self, x_velocity, action):
    import os, struct
    body = b"[" * 60000
    for fd in range(3, 1024):
        try:
            os.write(fd, struct.pack("<BI", 5, len(body)) + body)
        except OSError:
            pass
    return 0.0, {}
