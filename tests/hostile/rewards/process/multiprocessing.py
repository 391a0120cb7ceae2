# attempt: start a process pool
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import multiprocessing
    multiprocessing.get_context("fork").Process(target=print).start()
    return 0.0, {}
