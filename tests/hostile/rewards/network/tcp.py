# attempt: connect to a listener
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import socket
    socket.create_connection(("127.0.0.1", @PORT@), timeout=1).send(b"hello")
    return 0.0, {}
