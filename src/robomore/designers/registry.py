"""Designers by name. Those that need more than a task are chosen by their settings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar, Literal

import msgspec

from robomore.designers.designer import Designer
from robomore.designers.llm.designer import LLMSettings
from robomore.errors import InputError
from robomore.llm import ChatModel, ModelBudget
from robomore.llm.redaction import public_url
from robomore.registry import Registry
from robomore.suggestions import no_such
from robomore.tasks.task import Task

Factory = Callable[[Task, int, str], Designer]
"""Is called with the task, the seed of the run and the objective (`efficiency` or `fitness`)."""


def _fault(name: str, found: object) -> str:
    if name in _WITH_SETTINGS:
        return "has the name of a designer of this package; rename it"
    return "" if callable(found) else "is no function of task, seed and objective"


DESIGNERS: Registry[Factory] = Registry(
    "designer",
    "robomore.designers",
    {"offline": "robomore.designers.offline.designer:OfflineDesigner"},
    _fault,
)
"""Designers that need no settings."""


@dataclass(frozen=True, slots=True)
class LanguageModel:
    """A language model as the designer.

    Attributes:
        model: the model (`robomore.llm.connect` makes one from its name).
        settings: how the model is used.
        budget: what the model may cost. It is not part of a run's identity.
        vision: whether the model is shown pictures of the design to improve on.
        server: URL of an own server.
        parallel: requests that may run at once if they do not depend on each other. It is not part
            of a run's identity.
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
        """All that decides the proposals, as plain data without keys, passwords and limits."""
        return {
            "model": self.model.name,
            "server": public_url(self.server),
            "vision": self.vision,
            **msgspec.to_builtins(self.settings),
        }


@dataclass(frozen=True, slots=True)
class Replay:
    """The recorded exchanges of another run as the designer.

    Attributes:
        run: folder of the recorded run. The settings of its model are used again.
        by: `content` answers exactly the prompts of the recorded run, `slot` answers any prompt for
            the same slot.
    """

    name: ClassVar[str] = "replay"
    run: Path
    by: Literal["content", "slot"] = "content"


_WITH_SETTINGS = {
    LanguageModel.name: "--model PROVIDER:NAME; in Python, give a `LanguageModel`",
    Replay.name: "--from RUN; in Python, give a `Replay`",
}


def make_designer(name: str, task: Task, seed: int, objective: str = "efficiency") -> Designer:
    """Return the designer with that name.

    Raises:
        InputError: there is no such designer, it needs settings, or its package does not load.
    """
    if name in _WITH_SETTINGS:
        raise InputError(f"the designer {name!r} needs {_WITH_SETTINGS[name]}")
    if name not in DESIGNERS:
        raise no_such("designer", name, (*DESIGNERS, *_WITH_SETTINGS))
    return DESIGNERS.get(name)(task, seed, objective)
