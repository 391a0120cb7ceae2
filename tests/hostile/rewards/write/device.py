# attempt: make a device node of the disk
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os, stat
    os.mknod("disk", stat.S_IFBLK | 0o600, os.makedev(254, 0))
    return 0.0, {}
