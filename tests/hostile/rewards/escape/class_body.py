# attempt: run code in a class body
# expect: invalid-reward
# check: error

class Loot:
    secret = open("@SECRET@").read()


def _get_rew(self, x_velocity, action):
    return 0.0, {"loot": Loot.secret}
