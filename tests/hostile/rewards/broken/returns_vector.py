# attempt: return a vector
# expect: reward-failed
# check: clean

def _get_rew(self, x_velocity, action):
    return self.data.qvel, {}
