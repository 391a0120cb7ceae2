"""Weights & Biases, where `wandb` is installed. Its key and server are its own affair."""

from __future__ import annotations

import importlib
import os
from collections.abc import Mapping
from typing import ClassVar

from robomore.trackers.tracker import Tracked

PROJECT = "robomore"


class WeightsAndBiases:
    """Starts one run in the project `robomore` (`WANDB_PROJECT` names another)."""

    package: ClassVar[str] = "wandb"
    install: ClassVar[str] = "pip install wandb"

    def __init__(self, tracked: Tracked) -> None:
        library = importlib.import_module(self.package)
        settings = dict(tracked.settings)
        # Given by name, a project would overrule the user's variable.
        project = {} if os.environ.get("WANDB_PROJECT") else {"project": PROJECT}
        self._run = library.init(name=tracked.name, config=settings, **project)

    def log(self, values: Mapping[str, float], step: int) -> None:
        """See `Tracker.log`."""
        self._run.log(dict(values), step=step)

    def close(self) -> None:
        """See `Tracker.close`."""
        self._run.finish()
