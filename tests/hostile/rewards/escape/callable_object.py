# attempt: be an object that pretends to be a function
# expect: reward-failed
# check: error

class Reward:
    def __call__(self, robot, x_velocity, action):
        return open("@SECRET@").read(), {}


_get_rew = Reward()
