# attempt: reserve the disk's space
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    for index in range(64):
        with open(f"reserved-{index}", "wb") as file:
            os.posix_fallocate(file.fileno(), 0, 10**12)
    return 0.0, {}
