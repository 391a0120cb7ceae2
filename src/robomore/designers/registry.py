"""Designers by name: those that need nothing but a task, and those that other packages add."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib.metadata import entry_points

from robomore.designers.designer import Designer
from robomore.errors import InputError
from robomore.tasks.task import Task

GROUP = "robomore.designers"
"""Entry-point group: each entry names a `Factory`."""

Factory = Callable[[Task, int, str], Designer]
"""Called with the task, the run's seed and the objective (`efficiency` or `fitness`)."""


def _offline(task: Task, seed: int, objective: str) -> Designer:
    from robomore.designers.offline import OfflineDesigner

    return OfflineDesigner(task, seed, objective)


def _human(task: Task, seed: int, objective: str) -> Designer:
    from robomore.designers.human import HumanDesigner

    return HumanDesigner(task)


def _random(task: Task, seed: int, objective: str) -> Designer:
    from robomore.designers.random import RandomDesigner

    return RandomDesigner(task, seed)


DESIGNERS: dict[str, Factory] = {"offline": _offline, "human": _human, "random": _random}
"""Designers that need no settings of their own. They are imported when they are first made."""


def make_designer(name: str, task: Task, seed: int, objective: str = "efficiency") -> Designer:
    """Return the designer called `name`.

    Raises:
        InputError: there is none of that name, or a package that adds designers is broken.
    """
    factories = DESIGNERS if name in DESIGNERS else all_designers()
    if name not in factories:
        raise InputError(f"no designer is called {name!r}; choose one of {', '.join(factories)}")
    return factories[name](task, seed, objective)


@cache
def all_designers() -> dict[str, Factory]:
    """Return the factories of this package and of other installed ones, by name.

    Raises:
        InputError: an entry point does not load, or its name is taken.
    """
    found = dict(DESIGNERS)
    for entry in entry_points(group=GROUP):
        origin = f"{entry.name} = {entry.value}"
        if entry.name in found:
            raise InputError(f"two designers are called {entry.name!r}; rename that of {origin}")
        try:
            factory = entry.load()
        except Exception as error:
            raise InputError(
                f"the designer entry point {origin} does not load: {type(error).__name__}: {error}"
            ) from error
        if not callable(factory):
            raise InputError(
                f"the designer entry point {origin} is no function of task, seed and objective"
            )
        found[entry.name] = factory
    return found
