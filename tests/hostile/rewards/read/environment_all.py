# attempt: carry all variables out
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    raise RuntimeError(f"found: {dict(os.environ)}")
