# attempt: leave a file in /dev/shm
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    open("/dev/shm/@MARK@", "w").write("here")
    return 0.0, {}
