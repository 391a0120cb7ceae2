# attempt: return a term that does harm when unpickled
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    class Bomb:
        def __reduce__(self):
            import os
            return os.system, ("touch @OUTSIDE@/@MARK@",)

    return 0.0, {"bomb": Bomb()}
