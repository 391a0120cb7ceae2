# attempt: interrupt the main thread between calls
# expect: reward-failed or failed or ok
# check: error

def _get_rew(self, x_velocity, action):
    import _thread
    _thread.interrupt_main()
    return 0.0, {}
