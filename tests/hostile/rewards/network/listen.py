# attempt: listen on a port
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import socket
    socket.create_server(("127.0.0.1", 0)).listen()
    return 0.0, {}
