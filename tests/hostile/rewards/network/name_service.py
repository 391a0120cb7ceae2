# attempt: resolve a name that carries a secret out
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import socket
    socket.getaddrinfo("@MARK@.example.com", 80)
    return 0.0, {}
