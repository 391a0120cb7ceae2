# attempt: connect through asyncio
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import asyncio
    asyncio.run(asyncio.open_connection("127.0.0.1", @PORT@))
    return 0.0, {}
