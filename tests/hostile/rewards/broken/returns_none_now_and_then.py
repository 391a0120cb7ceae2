# attempt: return nothing now and then
# expect: reward-failed
# check: clean

def _get_rew(self, x_velocity, action):
    if x_velocity > 0:
        return float(x_velocity), {}
