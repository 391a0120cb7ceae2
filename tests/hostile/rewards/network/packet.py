# attempt: open a packet socket
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import socket
    socket.socket(socket.AF_PACKET, socket.SOCK_RAW)
    return 0.0, {}
