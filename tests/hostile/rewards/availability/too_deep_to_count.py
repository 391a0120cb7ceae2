# attempt: fill the disk below a path that is too long for whoever counts
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    if not self.__dict__.get("below"):
        for _ in range(30):
            os.mkdir("d" * 200)
            os.chdir("d" * 200)
        self.below = True
    with open(str(np.random.random()), "wb") as file:
        file.write(bytes(2_000_000))
    return 0.0, {}
