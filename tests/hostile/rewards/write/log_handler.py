# attempt: leave a file through logging
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import logging
    logging.getLogger().addHandler(logging.FileHandler("@OUTSIDE@/@MARK@"))
    return 0.0, {}
