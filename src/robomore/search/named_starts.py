"""Starts that need no file: morphologies that follow from the reference alone."""

from __future__ import annotations

from collections.abc import Callable

from robomore.search.slim_reference import SlimReferenceSettings, slim
from robomore.tasks.task import Task
from robomore.types import Morphology, Start


def _reference(task: Task) -> Morphology:
    return Morphology(task.reference, "the reference")


def _slim_reference(task: Task) -> Morphology:
    return slim(task, SlimReferenceSettings())[0]


NAMED_STARTS: dict[str, Callable[[Task], Morphology]] = {
    "reference": _reference,
    "slim-reference": _slim_reference,
}
"""What `--start-from` takes in the place of a file."""


def named_start(task: Task, name: str) -> Start:
    """Return the start of that name, one of `NAMED_STARTS`, which is a morphology.

    Raises:
        InputError: the task has no radii, so there is no slim reference.
    """
    return Start(name, NAMED_STARTS[name](task))
