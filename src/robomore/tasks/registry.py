"""All tasks by id: the eight of the paper, and those that other packages add by an entry point."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from functools import cache
from importlib.metadata import entry_points

from robomore.errors import InputError
from robomore.tasks.ant import ANT, ANT_DESERT, ANT_JUMP, ANT_POWERED
from robomore.tasks.half_cheetah import HALF_CHEETAH
from robomore.tasks.hopper import HOPPER
from robomore.tasks.swimmer import SWIMMER
from robomore.tasks.task import Task
from robomore.tasks.walker import WALKER

GROUP = "robomore.tasks"
"""Entry-point group: each entry names a `Task`."""


def by_id(tasks: Iterable[Task]) -> dict[str, Task]:
    """Return tasks by their id.

    Raises:
        InputError: two tasks have the same id.
    """
    found: dict[str, Task] = {}
    for task in tasks:
        if task.id in found:
            raise InputError(f"two tasks are called '{task.id}'; rename one of them")
        found[task.id] = task
    return found


TASKS = by_id((ANT, ANT_POWERED, ANT_DESERT, ANT_JUMP, HOPPER, HALF_CHEETAH, SWIMMER, WALKER))
"""The eight tasks of the paper."""


def get_task(id: str) -> Task:
    """Return a task by its id.

    Raises:
        InputError: there is no such task, or a package that adds tasks is broken.
    """
    if id in TASKS:
        return TASKS[id]
    tasks = all_tasks()
    if id in tasks:
        return tasks[id]
    near = get_close_matches(str(id), tasks, n=1)
    hint = f" Did you mean '{near[0]}'?" if near else ""
    raise InputError(f"no task is called '{id}'.{hint} Tasks: {', '.join(tasks)}")


@cache
def all_tasks() -> dict[str, Task]:
    """Return the eight tasks and those of other installed packages, by id.

    Raises:
        InputError: an entry point does not load, gives something that is not a `Task`, or gives
            one whose id is taken.
    """
    return by_id([*TASKS.values(), *_from_entry_points()])


def _from_entry_points() -> list[Task]:
    found = []
    for entry in entry_points(group=GROUP):
        origin = f"{entry.name} = {entry.value}" + (f" ({entry.dist.name})" if entry.dist else "")
        try:
            task = entry.load()
        except Exception as error:
            raise InputError(
                f"the task entry point {origin} does not load: {type(error).__name__}: {error}"
            ) from error
        if not isinstance(task, Task):
            raise InputError(f"the task entry point {origin} is a {type(task).__name__}, no Task")
        found.append(task)
    return found
