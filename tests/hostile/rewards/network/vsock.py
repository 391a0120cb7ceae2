# attempt: talk to the host of a virtual machine
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import socket
    socket.socket(40, socket.SOCK_STREAM).connect((2, 1))
    return 0.0, {}
