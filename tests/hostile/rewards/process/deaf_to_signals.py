# attempt: ignore all signals and loop
# expect: timed-out
# check: error

def _get_rew(self, x_velocity, action):
    import signal
    for number in set(signal.Signals) - {signal.SIGKILL, signal.SIGSTOP}:
        try:
            signal.signal(number, signal.SIG_IGN)
        except OSError:
            pass
    while True:
        pass
