# attempt: climb from a traceback's frame to the trainer
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    try:
        raise ValueError
    except ValueError as error:
        frame = error.__traceback__.tb_frame
    names = []
    while frame is not None:
        names.append(frame.f_code.co_name)
        opened = frame.f_globals.get("open")
        frame = frame.f_back
    import os
    loot = os.environ["@VARIABLE@"]
    raise RuntimeError(f"loot: {loot!r}")
