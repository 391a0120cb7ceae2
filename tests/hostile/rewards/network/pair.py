# attempt: make a pair of sockets
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import socket
    socket.socketpair()
    return 0.0, {}
