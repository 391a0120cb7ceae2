"""Names that a shell completes: of tasks, presets and methods, those of other packages included."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from cyclopts import Parameter


def _names(what: str) -> Callable[[Any], tuple[str, ...]]:
    def found(context: Any) -> tuple[str, ...]:
        # Loaded when a shell asks, because every command loads this module.
        if what == "task":
            from robomore.tasks import TASKS

            return TASKS.names()
        if what == "preset":
            from robomore.settings import PRESETS

            return tuple(PRESETS)
        from robomore.search import METHODS

        return tuple(METHODS)

    return found


TASK = Parameter(completer=_names("task"))
PRESET = Parameter(completer=_names("preset"))
METHOD = Parameter(completer=_names("method"))
