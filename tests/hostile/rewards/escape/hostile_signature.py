# attempt: lie about the own signature
# expect: invalid-reward
# check: error

class Reward:
    @property
    def __signature__(self):
        return open("@SECRET@").read()

    def __call__(self, robot, x_velocity, action):
        return 0.0, {}


_get_rew = Reward()
