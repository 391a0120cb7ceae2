# attempt: run code in a default argument
# expect: invalid-reward
# check: error

def _get_rew(self, x_velocity, action, loot=open("@SECRET@").read()):
    return 0.0, {"loot": loot}
