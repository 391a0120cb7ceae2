# attempt: fill the disk with many files
# expect: reward-failed or timed-out
# check: error

def _get_rew(self, x_velocity, action):
    for index in range(2000):
        open(f"{id(self)}-{self.training_steps}-{index}", "w").close()
    return 0.0, {}
