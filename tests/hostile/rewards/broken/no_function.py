# attempt: defines another function
# expect: invalid-reward
# check: error

def reward(self, x_velocity, action):
    return float(x_velocity), {}
