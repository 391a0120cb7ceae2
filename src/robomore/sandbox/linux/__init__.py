"""What Linux offers to keep untrusted code in: Landlock, seccomp, and the numbers in /proc.

Each module wraps one mechanism of the kernel and knows nothing of rewards or robots.
"""
