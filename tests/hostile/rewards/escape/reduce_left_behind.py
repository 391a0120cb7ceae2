# attempt: leave a pickle in the place of the policy
# expect: ok
# check: error

def _get_rew(self, x_velocity, action):
    import pickle

    class Bomb:
        def __reduce__(self):
            import os
            return os.system, ("touch @OUTSIDE@/@MARK@",)

    with open("training.pkl", "wb") as file:
        pickle.dump(Bomb(), file)
    return 0.0, {}
