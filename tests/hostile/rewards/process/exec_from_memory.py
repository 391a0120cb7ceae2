# attempt: run a program that exists in memory only
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    fd = os.memfd_create("program")
    os.write(fd, b"#!/bin/sh\nsleep 30\n")
    os.execve(fd, ["program"], {})
