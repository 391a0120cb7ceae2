# attempt: run code as the text is loaded
# expect: invalid-reward
# check: error

import os

os.makedirs("@OUTSIDE@/@MARK@")


def _get_rew(self, x_velocity, action):
    return 0.0, {}
