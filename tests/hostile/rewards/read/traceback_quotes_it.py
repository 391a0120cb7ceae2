# attempt: have a traceback quote a file's lines
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import traceback
    try:
        exec(compile("1/0", "@SECRET@", "exec"))
    except ZeroDivisionError:
        raise RuntimeError(f"found: {traceback.format_exc()}")
