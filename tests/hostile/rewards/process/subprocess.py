# attempt: run a program
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import subprocess
    subprocess.run(["touch", "@OUTSIDE@/@MARK@"], check=True)
    return 0.0, {}
