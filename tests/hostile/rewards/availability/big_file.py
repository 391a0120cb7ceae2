# attempt: fill the disk with one file
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    with open("big", "wb") as file:
        while True:
            file.write(bytes(1_000_000))
