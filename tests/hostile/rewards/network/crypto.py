# attempt: use the kernel's crypto sockets
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import socket
    socket.socket(38, socket.SOCK_SEQPACKET)
    return 0.0, {}
