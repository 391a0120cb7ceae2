"""trackio, which keeps its numbers on this machine unless it is told otherwise."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import ClassVar

from robomore.trackers.tracker import Tracked

PROJECT = "robomore"


class Trackio:
    """Starts one run in the project `robomore`."""

    package: ClassVar[str] = "trackio"
    install: ClassVar[str] = "pip install trackio"

    def __init__(self, tracked: Tracked) -> None:
        self._library = importlib.import_module(self.package)
        self._library.init(project=PROJECT, name=tracked.name, config=dict(tracked.settings))

    def log(self, values: Mapping[str, float], step: int) -> None:
        """See `Tracker.log`."""
        self._library.log(dict(values), step=step)

    def close(self) -> None:
        """See `Tracker.close`."""
        self._library.finish()
