# attempt: takes other arguments
# expect: invalid-reward
# check: error

def _get_rew(obs, action):
    return 0.0, {}
