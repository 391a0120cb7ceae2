# attempt: grow a list for ever
# expect: out-of-memory
# check: error

def _get_rew(self, x_velocity, action):
    grown = []
    while True:
        grown.append(bytes(10_000_000))
