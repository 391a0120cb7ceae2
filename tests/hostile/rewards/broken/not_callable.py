# attempt: is a number
# expect: invalid-reward
# check: error

_get_rew = 42
