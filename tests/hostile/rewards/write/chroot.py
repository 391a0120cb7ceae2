# attempt: change the root and escape from it
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.mkdir("jail")
    here = os.open(".", os.O_RDONLY)
    os.chroot("jail")
    os.fchdir(here)
    os.chdir("../" * 20)
    open(".@OUTSIDE@/@MARK@", "w").write("here")
    return 0.0, {}
