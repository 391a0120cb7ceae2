# attempt: fill the disk with files that have no name any more
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    kept = self.__dict__.setdefault("kept", [])
    file = open("big", "wb")
    os.unlink("big")
    file.write(bytes(4_000_000))
    kept.append(file)
    return 0.0, {}
