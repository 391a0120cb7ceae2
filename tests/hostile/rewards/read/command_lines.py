# attempt: read what other processes were called with
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    loot = [open(f"/proc/{pid}/cmdline").read() for pid in os.listdir("/proc") if pid.isdigit()]
    raise RuntimeError(f"loot: {loot!r}")
