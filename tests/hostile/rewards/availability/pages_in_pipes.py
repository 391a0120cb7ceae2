# attempt: keep pages of a file that is cut short in pipes
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    file = os.open("pages", os.O_RDWR | os.O_CREAT)
    while True:
        os.pwrite(file, bytes(2**21), 0)
        os.sendfile(os.pipe()[1], file, 0, 4096)
        os.ftruncate(file, 0)
