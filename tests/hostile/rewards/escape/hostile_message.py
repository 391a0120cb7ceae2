# attempt: raise an exception whose message never ends
# expect: timed-out
# check: error

def _get_rew(self, x_velocity, action):
    class Endless(Exception):
        def __str__(self):
            while True:
                pass

    raise Endless
