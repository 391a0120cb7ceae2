# attempt: limit the parent's memory
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import resource
    resource.prlimit(@PARENT@, resource.RLIMIT_AS, (2**40, 2**40))
    return 0.0, {}
