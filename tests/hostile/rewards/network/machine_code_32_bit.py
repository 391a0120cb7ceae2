# attempt: make a 32-bit system call in machine code
# expect: crashed or reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes, mmap, platform
    if platform.machine() != "x86_64":
        raise PermissionError("another machine")
    # mov eax, 359 (socket, 32-bit); mov ebx, 2; mov ecx, 1; xor edx, edx; int 0x80; ret
    code = bytes.fromhex("53b867010000bb02000000b90100000031d2cd805bc3")
    page = mmap.mmap(-1, 4096, prot=mmap.PROT_READ | mmap.PROT_WRITE | mmap.PROT_EXEC)
    page.write(code)
    call = ctypes.CFUNCTYPE(ctypes.c_int)(ctypes.addressof(ctypes.c_char.from_buffer(page)))
    if call() < 0:
        raise PermissionError
    return 0.0, {}
