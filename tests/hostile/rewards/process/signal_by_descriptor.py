# attempt: have a pipe signal the parent when data arrives
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import fcntl, os
    reader, writer = os.pipe()
    fcntl.fcntl(reader, fcntl.F_SETOWN, @PARENT@)
    fcntl.fcntl(reader, 10, 9)  # F_SETSIG, SIGKILL
    fcntl.fcntl(reader, fcntl.F_SETFL, os.O_ASYNC)
    os.write(writer, b"x")
    return 0.0, {}
