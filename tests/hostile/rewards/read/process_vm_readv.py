# attempt: read the parent's memory by system call
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes
    libc = ctypes.CDLL(None, use_errno=True)
    buffer = ctypes.create_string_buffer(64)
    local = (ctypes.c_void_p * 2)(ctypes.addressof(buffer), 64)
    remote = (ctypes.c_void_p * 2)(0x400000, 64)
    if libc.process_vm_readv(@PARENT@, local, 1, remote, 1, 0) < 0 and ctypes.get_errno() == 1:
        raise PermissionError
    loot = buffer.raw, "or nothing at that address, but allowed"
    raise RuntimeError(f"loot: {loot!r}")
