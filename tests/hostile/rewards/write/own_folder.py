# attempt: write files into the own folder, which is allowed
# expect: ok
# check: error

def _get_rew(self, x_velocity, action):
    import os
    os.makedirs("notes", exist_ok=True)
    with open("notes/a.txt", "w") as file:
        file.write("allowed")
    return 0.0, {}
