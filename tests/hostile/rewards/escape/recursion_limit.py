# attempt: lift the recursion limit and recurse
# expect: crashed or reward-failed or out-of-memory or timed-out
# check: error

def _get_rew(self, x_velocity, action):
    import sys
    sys.setrecursionlimit(10**9)

    def down(n):
        return [down(n + 1)]

    return float(down(0)[0]), {}
