# attempt: connect to an abstract Unix socket
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import socket
    socket.socket(socket.AF_UNIX).connect("\0@MARK@")
    return 0.0, {}
