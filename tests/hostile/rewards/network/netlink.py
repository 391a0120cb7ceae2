# attempt: talk to the kernel over netlink
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import socket
    socket.socket(socket.AF_NETLINK, socket.SOCK_RAW, 0)
    return 0.0, {}
