# attempt: use an attribute that is not there
# expect: reward-failed
# check: clean

def _get_rew(self, x_velocity, action):
    return self.data.no_such_thing, {}
