# attempt: defines the function inside a class
# expect: invalid-reward
# check: error

class AntEnv:
    def _get_rew(self, x_velocity, action):
        return float(x_velocity), {}
