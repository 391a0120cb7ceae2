# attempt: read the password file
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    loot = open("/etc/shadow").read() + open("/etc/passwd").read()
    raise RuntimeError(f"loot: {loot!r}")
