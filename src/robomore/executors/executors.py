"""Executors by name. A new one is one file beside this one, and one line here."""

from __future__ import annotations

from collections.abc import Callable

from robomore.executors.executor import Executor
from robomore.registry import Registry

Factory = Callable[[int], Executor]
"""Called with the number of evaluations that may go on side by side."""


def _fault(name: str, found: object) -> str:
    return "" if callable(found) else "is no function of the number of workers"


EXECUTORS: Registry[Factory] = Registry(
    "executor",
    "robomore.executors",
    {
        "processes": "robomore.executors.processes:Processes",
        "inline": "robomore.executors.inline:Inline",
        "ray": "robomore.executors.ray:Ray",
    },
    _fault,
)
