# attempt: teleport the robot
# expect: ok
# check: error

def _get_rew(self, x_velocity, action):
    self.data.qpos[0] += 1000.0
    return float(self.data.qpos[0]), {}
