# attempt: start workers through concurrent.futures
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    from concurrent.futures import ProcessPoolExecutor
    with ProcessPoolExecutor(2) as pool:
        return float(sum(pool.map(abs, [1, 2]))), {}
