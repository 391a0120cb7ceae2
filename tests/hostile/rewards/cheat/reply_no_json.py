# attempt: answer with bytes that are no JSON
# expect: ok
# check: error

def _get_rew(self, x_velocity, action):
    import os, struct
    body = b"\xff\xfe" * 100
    for fd in range(3, 1024):
        try:
            os.write(fd, struct.pack("<BI", 4, len(body)) + body)
        except OSError:
            pass
    return 0.0, {}
