# attempt: imports a package that is not there
# expect: invalid-reward
# check: error

import no_such_package


def _get_rew(self, x_velocity, action):
    return float(x_velocity), {}
