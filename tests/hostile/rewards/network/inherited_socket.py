# attempt: use a descriptor that was inherited as a socket
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import socket
    for fd in range(256):
        try:
            socket.socket(fileno=fd).connect(("127.0.0.1", @PORT@))
            return 0.0, {}
        except OSError:
            continue
    raise PermissionError("no socket was inherited")
