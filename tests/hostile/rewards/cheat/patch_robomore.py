# attempt: replace RoboMoRe's functions in the child
# expect: ok
# check: error

def _get_rew(self, x_velocity, action):
    import sys
    for name in ("robomore.rewards.load", "robomore.sandbox.untrusted_files", "miniature"):
        module = sys.modules.get(name)
        if module is not None:
            module.measure = module.read_file = lambda *a: 1e9
    return 0.0, {}
