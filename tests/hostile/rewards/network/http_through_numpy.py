# attempt: have numpy fetch a page
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    np.loadtxt("http://127.0.0.1:@PORT@/")
    return 0.0, {}
