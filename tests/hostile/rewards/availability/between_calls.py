# attempt: hang the interpreter between two calls
# expect: timed-out
# check: error

def _get_rew(self, x_velocity, action):
    import sys, threading

    def busy():
        while True:
            pass

    sys.setswitchinterval(1000.0)
    threading.Thread(target=busy, daemon=True).start()
    return 0.0, {}
