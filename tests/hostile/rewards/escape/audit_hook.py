# attempt: hook audits of the interpreter
# expect: ok
# check: error

def _get_rew(self, x_velocity, action):
    import sys
    if not getattr(self, "hooked", False):
        self.hooked = True
        sys.addaudithook(lambda event, arguments: None)
    return 0.0, {}
