# attempt: change RoboMoRe itself
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import robomore.types
    open(robomore.types.__file__, "a")
    return 0.0, {}
