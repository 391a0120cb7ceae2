# attempt: rename the machine
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import socket
    socket.sethostname(socket.gethostname())
    return 0.0, {}
