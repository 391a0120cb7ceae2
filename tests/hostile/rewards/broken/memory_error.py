# attempt: raise MemoryError
# expect: out-of-memory
# check: error

def _get_rew(self, x_velocity, action):
    raise MemoryError
