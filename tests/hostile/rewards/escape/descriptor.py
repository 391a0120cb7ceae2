# attempt: hide a read in a descriptor
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    class Door:
        def __get__(self, owner, kind):
            return open("@SECRET@").read()

    type(self).door = Door()
    return float(len(self.door)), {}
