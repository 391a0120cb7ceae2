# attempt: change the physics
# expect: ok
# check: error

def _get_rew(self, x_velocity, action):
    self.model.opt.timestep = 100.0
    self.dt = 100.0
    return float(x_velocity), {}
