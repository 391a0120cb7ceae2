# attempt: leave an object whose end runs code
# expect: ok
# check: error

def _get_rew(self, x_velocity, action):
    class Late:
        def __del__(self):
            open("@OUTSIDE@/@MARK@", "w").write("here")

    self.late = Late()
    return 0.0, {}
