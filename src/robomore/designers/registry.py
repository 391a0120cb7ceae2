"""Designers to choose from: by name where a task is all they need, else with their settings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any, ClassVar, Literal
from urllib.parse import urlsplit, urlunsplit

import msgspec

from robomore.designers.designer import Designer
from robomore.designers.llm.designer import LLMSettings
from robomore.errors import InputError
from robomore.llm import ChatModel, ModelBudget
from robomore.tasks.task import Task

GROUP = "robomore.designers"
"""Entry-point group: each entry names a `Factory`."""

Factory = Callable[[Task, int, str], Designer]
"""Called with the task, the run's seed and the objective (`efficiency` or `fitness`)."""


def _offline(task: Task, seed: int, objective: str) -> Designer:
    from robomore.designers.offline.designer import OfflineDesigner

    return OfflineDesigner(task, seed, objective)


def _human(task: Task, seed: int, objective: str) -> Designer:
    from robomore.designers.human import HumanDesigner

    return HumanDesigner(task)


def _random(task: Task, seed: int, objective: str) -> Designer:
    from robomore.designers.random import RandomDesigner

    return RandomDesigner(task, seed)


DESIGNERS: dict[str, Factory] = {"offline": _offline, "human": _human, "random": _random}
"""Designers that need no settings of their own. They are imported when they are first made."""


@dataclass(frozen=True, slots=True)
class LanguageModel:
    """A language model as the designer.

    Attributes:
        model: what is asked (`robomore.llm.connect` gives one by its name).
        settings: how it is used.
        budget: what it may cost; no part of a run's identity.
        vision: whether it is shown pictures of what it is to improve.
        server: URL of a server of one's own.
        parallel: requests under way at once, where they do not depend on each other; no part of a
            run's identity.
    """

    name: ClassVar[str] = "llm"
    model: ChatModel
    settings: LLMSettings = field(default_factory=LLMSettings)
    budget: ModelBudget = field(default_factory=ModelBudget)
    vision: bool = False
    server: str = ""
    parallel: int = 4

    @property
    def identity(self) -> dict[str, Any]:
        """What decides the proposals, as plain data: no key, no password, no limit."""
        return {
            "model": self.model.name,
            "server": _public(self.server),
            "vision": self.vision,
            **msgspec.to_builtins(self.settings),
        }


@dataclass(frozen=True, slots=True)
class Replay:
    """The recorded exchanges of another run as the designer.

    Attributes:
        run: folder of the recorded run, whose settings of the model hold again.
        by: `content` answers the very prompts of the recorded run, `slot` whatever is asked in the
            same place.
    """

    name: ClassVar[str] = "replay"
    run: Path
    by: Literal["content", "slot"] = "content"


_WITH_SETTINGS = {
    LanguageModel.name: "--model PROVIDER:NAME; in Python, give a `LanguageModel`",
    Replay.name: "--from RUN; in Python, give a `Replay`",
}


def make_designer(name: str, task: Task, seed: int, objective: str = "efficiency") -> Designer:
    """Return the designer called `name`.

    Raises:
        InputError: there is none of that name, or a package that adds designers is broken.
    """
    if name in _WITH_SETTINGS:
        raise InputError(f"the designer {name!r} needs {_WITH_SETTINGS[name]}")
    factories = DESIGNERS if name in DESIGNERS else all_designers()
    if name not in factories:
        names = ", ".join([*factories, *_WITH_SETTINGS])
        raise InputError(f"no designer is called {name!r}; choose one of {names}")
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


def _public(url: str) -> str:
    """Return a URL without what may be secret in it."""
    parts = urlsplit(url)
    return urlunsplit((parts.scheme, parts.netloc.rpartition("@")[2], parts.path, "", ""))
