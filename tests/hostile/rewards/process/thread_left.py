# attempt: leave a thread behind that never ends
# expect: ok
# check: error

def _get_rew(self, x_velocity, action):
    import threading, time
    if threading.active_count() < 3:
        threading.Thread(target=time.sleep, args=(30,)).start()
    return 0.0, {}
