"""What a tracker is told, and what it has to do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Protocol


@dataclass(frozen=True, slots=True)
class Tracked:
    """The run that is followed.

    Attributes:
        folder: of the run.
        name: for people.
        settings: everything that decides its numbers, as plain values by name.
    """

    folder: Path
    name: str
    settings: Mapping[str, Any]


class Tracker(Protocol):
    """Keeps numbers of one run somewhere. It is made with a `Tracked`, and used in one thread.

    Attributes:
        package: module that has to be installed; empty for none.
        install: command that installs it.
    """

    package: ClassVar[str]
    install: ClassVar[str]

    def __init__(self, tracked: Tracked) -> None: ...

    def log(self, values: Mapping[str, float], step: int) -> None:
        """Keep numbers by name; `step` counts finished evaluations and never falls."""
        ...

    def close(self) -> None:
        """Finish; nothing is logged after it."""
        ...
