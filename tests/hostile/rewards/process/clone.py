# attempt: clone by system call
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes, platform
    number = {"x86_64": 56, "aarch64": 220}[platform.machine()]
    pid = ctypes.CDLL(None).syscall(number, 17, 0, 0, 0, 0)
    if pid < 0:
        raise PermissionError
    if pid == 0:
        import os
        os._exit(0)
    return 0.0, {}
