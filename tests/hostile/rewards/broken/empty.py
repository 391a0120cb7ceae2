# attempt: is empty
# expect: invalid-reward
# check: error

# nothing here
