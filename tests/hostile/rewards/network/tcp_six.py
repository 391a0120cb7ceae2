# attempt: connect over IPv6
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import socket
    socket.socket(socket.AF_INET6).connect(("::1", @PORT@))
    return 0.0, {}
