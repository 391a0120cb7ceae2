# attempt: leave a link in the place of the policy
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.symlink("@SECRET@", "policy.json")
    return 0.0, {}
