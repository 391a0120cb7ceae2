# attempt: leave a shared memory object
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    from multiprocessing import shared_memory
    shared_memory.SharedMemory("@MARK@", create=True, size=4096)
    return 0.0, {}
