# attempt: reach another folder through /proc
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    open("/proc/self/root@NEIGHBOUR@/policy.json", "w").write('{"force": -1}')
    return 0.0, {}
