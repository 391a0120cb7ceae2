# attempt: take memory in a thread that outlives the first one, whose memory is watched
# expect: out-of-memory or timed-out or crashed
# check: error

def _get_rew(self, x_velocity, action):
    import ctypes
    import threading
    def take():
        kept = []
        while True:
            kept.append(bytearray(8_000_000))
    threading.Thread(target=take).start()
    ctypes.CDLL(None).syscall(60 if ctypes.sizeof(ctypes.c_long) else 93, 0)
    return 0.0, {}
