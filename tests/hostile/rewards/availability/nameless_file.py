# attempt: fill the disk with files that never had a name
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    kept = self.__dict__.setdefault("kept", [])
    kept.append(os.open(".", os.O_TMPFILE | os.O_RDWR))
    os.write(kept[-1], bytes(4_000_000))
    return 0.0, {}
