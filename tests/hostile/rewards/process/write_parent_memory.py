# attempt: write to the parent's memory
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes
    libc = ctypes.CDLL(None, use_errno=True)
    buffer = ctypes.create_string_buffer(8)
    local = (ctypes.c_void_p * 2)(ctypes.addressof(buffer), 8)
    remote = (ctypes.c_void_p * 2)(0x400000, 8)
    if libc.process_vm_writev(@PARENT@, local, 1, remote, 1, 0) < 0 and ctypes.get_errno() == 1:
        raise PermissionError
    return 0.0, {}
