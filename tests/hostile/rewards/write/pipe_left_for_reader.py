# attempt: leave a named pipe in the place of the policy
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.mkfifo("policy.json")
    return 0.0, {}
