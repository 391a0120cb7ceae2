# attempt: have the kernel run a program on the next crash
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    open("/proc/sys/kernel/core_pattern", "r+")
    return 0.0, {}
