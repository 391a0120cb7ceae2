# attempt: replace another candidate's policy
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    open("@NEIGHBOUR@/policy.json", "w").write('{"force": -1}')
    return 0.0, {}
