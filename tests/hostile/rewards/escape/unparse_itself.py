# attempt: rewrite the trainer's code object
# expect: ok or crashed or failed or reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import sys
    frame = sys._getframe()
    while frame.f_code.co_name != "train":
        frame = frame.f_back
    function = frame.f_globals["measure"]
    function.__code__ = (lambda scratch: 1e9).__code__
    return 0.0, {}
