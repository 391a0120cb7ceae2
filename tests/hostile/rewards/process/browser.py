# attempt: open a web browser
# expect: reward-failed or ok
# check: error

def _get_rew(self, x_velocity, action):
    import webbrowser
    webbrowser.open("http://127.0.0.1:@PORT@/")
    return 0.0, {}
