# attempt: signal the parent through a descriptor
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os, signal
    signal.pidfd_send_signal(os.pidfd_open(@PARENT@), signal.SIGKILL)
    return 0.0, {}
