# attempt: hide a read in a metaclass
# expect: invalid-reward
# check: error

class Meta(type):
    def __getattr__(cls, name):
        return open("@SECRET@").read()


class Loot(metaclass=Meta):
    pass


LOOT = Loot.anything


def _get_rew(self, x_velocity, action):
    return 0.0, {}
