# attempt: let another candidate's training go on from elsewhere
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import os
    import pathlib

    folder = pathlib.Path("@NEIGHBOUR@")
    failed = None
    for attempt in (
        lambda: (folder / "checkpoint.json").write_text("{}"),
        lambda: (folder / "arrays-0.npz").open("r+b").write(b"PK"),
        lambda: (folder / "arrays-1.npz").write_bytes(b"PK"),
        lambda: os.replace(folder / "arrays-0.npz", folder / "arrays-1.npz"),
        lambda: (folder / "checkpoint.json").unlink(),
        lambda: os.truncate(folder / "arrays-0.npz", 1),
    ):
        try:
            attempt()
        except OSError as error:
            failed = error
    raise failed
