# attempt: answer with JSON that is nested too deeply
# expect: ok
# check: error

def _get_rew(self, x_velocity, action):
    import os, struct
    body = b"[" * 60000
    for fd in range(3, 1024):
        try:
            os.write(fd, struct.pack("<BI", 4, len(body)) + body)
        except OSError:
            pass
    return 0.0, {}
