# attempt: start threads without end
# expect: reward-failed or out-of-memory or timed-out
# check: error

def _get_rew(self, x_velocity, action):
    import threading, time
    threading.stack_size(32768)
    while True:
        threading.Thread(target=time.sleep, args=(30,), daemon=True).start()
