# attempt: raise the own limits
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import resource
    resource.setrlimit(resource.RLIMIT_DATA, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
    return 0.0, {}
