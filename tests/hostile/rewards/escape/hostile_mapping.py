# attempt: return terms that never end
# expect: timed-out
# check: clean

def _get_rew(self, x_velocity, action):
    class Terms(dict):
        def items(self):
            while True:
                yield "x", 1.0

    return 0.0, Terms()
