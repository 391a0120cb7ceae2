# attempt: hook all further imports
# expect: ok
# check: error

def _get_rew(self, x_velocity, action):
    import sys

    class Finder:
        def find_spec(self, name, path=None, target=None):
            raise ImportError(name)

    if len(sys.meta_path) < 10:
        sys.meta_path.insert(0, Finder())
    return 0.0, {}
