# attempt: hook the search for codecs
# expect: ok
# check: error

def _get_rew(self, x_velocity, action):
    import codecs

    def search(name):
        try:
            open("@SECRET@").read()
        except OSError:
            return None

    codecs.register(search)
    try:
        "x".encode("hostile")
    except LookupError:
        pass
    return 0.0, {}
