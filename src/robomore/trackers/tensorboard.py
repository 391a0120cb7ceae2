"""TensorBoard's files in the run's folder, written by tensorboardX (extra `tensorboard`)."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import ClassVar

from robomore.plain_files import PlainFolder
from robomore.text import to_json
from robomore.trackers.tracker import Tracked

FOLDER = "tensorboard"


class TensorBoard:
    """Writes `tensorboard/` in the run's folder: `tensorboard --logdir runs`."""

    package: ClassVar[str] = "tensorboardX"
    install: ClassVar[str] = "pip install 'robomore[tensorboard]'"

    def __init__(self, tracked: Tracked) -> None:
        # The folder may come from somebody else: what is no plain file in it is refused.
        files = PlainFolder(tracked.folder)
        files.make(FOLDER)
        files.check(FOLDER)
        library = importlib.import_module(self.package)
        # A run that is continued tells everything again, which replaces what was there.
        self._writer = library.SummaryWriter(str(tracked.folder / FOLDER), purge_step=0)
        settings = to_json(tracked.settings).decode()
        self._writer.add_text("settings", f"    {settings}", 0)

    def log(self, values: Mapping[str, float], step: int) -> None:
        """See `Tracker.log`."""
        for name, value in values.items():
            self._writer.add_scalar(name, value, step)

    def close(self) -> None:
        """See `Tracker.close`."""
        self._writer.close()
