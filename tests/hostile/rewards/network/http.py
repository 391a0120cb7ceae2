# attempt: fetch a page
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import urllib.request
    urllib.request.urlopen("http://127.0.0.1:@PORT@/", timeout=1)
    return 0.0, {}
