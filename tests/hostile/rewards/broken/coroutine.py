# attempt: is a coroutine
# expect: reward-failed
# check: error

async def _get_rew(self, x_velocity, action):
    return float(x_velocity), {}
