# attempt: change the limits of a control group
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import glob
    written = 0
    for path in glob.glob("/sys/fs/cgroup/**/memory*limit*", recursive=True)[:3] or ["/sys/fs/cgroup/x"]:
        open(path, "r+")
    return 0.0, {}
