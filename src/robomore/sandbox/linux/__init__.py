"""What Linux offers to restrict a process: Landlock, seccomp, privileges, and the numbers in /proc.

Each module wraps one mechanism of the kernel. None knows of rewards or robots, and none imports
anything of RoboMoRe outside this package. On other systems they refuse with an `OSError`.
"""
