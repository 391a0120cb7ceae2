"""What goes on in a run, told as it happens to whoever watches (the live view, a log, a test)."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from robomore.plan import Plan
from robomore.settings import RunSettings
from robomore.types import Evaluation, Place, Slot


@dataclass(frozen=True, slots=True)
class RunBegan:
    """A run's folder is ready and nothing has been asked for yet.

    Attributes:
        task: id of the task.
        preset: name of the settings.
        settings: what the preset stands for, the method's name among it.
        plan: the stages to come, the final among them.
        designer: name of the designer; empty for a method that asks none.
        provenance: one plain sentence on what makes the proposals.
        seed: of the run.
        workers: evaluations that may go on side by side.
        folder: where everything is written.
        containment: how untrusted code is kept in, and by which layers.
        budget_steps: control steps of training that the search may use; `None` for no bound.
        time_limit: wall-clock seconds after which nothing new is started; `None` for no bound.
        fitness_unit: unit of the task's fitness; empty for a number without one.
    """

    task: str
    preset: str
    settings: RunSettings
    plan: Plan
    designer: str
    provenance: str
    seed: int
    workers: int
    folder: Path
    containment: str = ""
    budget_steps: int | None = None
    time_limit: float | None = None
    fitness_unit: str = ""


@dataclass(frozen=True, slots=True)
class Proposed:
    """A designer filled a slot, or could not (`failure` says why)."""

    slot: Slot
    idea: str
    failure: str = ""


@dataclass(frozen=True, slots=True)
class Waiting:
    """A language model is asked to fill a slot; `over` when it has answered, or will not."""

    slot: Slot
    over: bool = False


@dataclass(frozen=True, slots=True)
class Spent:
    """A language model answered.

    Attributes:
        requests: sent by the run so far, interruptions included.
        tokens: in and out.
        dollars: US dollars; `None` where a price is not known.
    """

    requests: int
    tokens: int
    dollars: float | None


@dataclass(frozen=True, slots=True)
class BatchBegan:
    """The search asked for a batch of evaluations, some of which may be known already.

    Attributes:
        places: one for each evaluation; trials of equal content share an evaluation.
        known: how many of them were measured before.
    """

    places: tuple[Place, ...]
    known: int


@dataclass(frozen=True, slots=True)
class Started:
    """A worker took up an evaluation."""

    key: str
    place: Place
    steps: int


@dataclass(frozen=True, slots=True)
class Progressed:
    """An evaluation has done so many control steps of training."""

    key: str
    steps: int


@dataclass(frozen=True, slots=True)
class Finished:
    """An evaluation is in the ledger; `known` if it was there before."""

    evaluation: Evaluation
    place: Place
    known: bool


@dataclass(frozen=True, slots=True)
class Cut:
    """Screening gives no more training to a pair of the grid.

    Attributes:
        place: of the pair.
        steps: of training that it had, 0 if it was not tried at all.
        reason: in words.
    """

    place: Place
    steps: int
    reason: str


Event = RunBegan | Proposed | Waiting | Spent | BatchBegan | Started | Progressed | Finished | Cut
Observer = Callable[[Event], None]


def one_at_a_time(observe: Observer) -> Observer:
    """Return an observer that may be told from several threads."""
    lock = threading.Lock()

    def tell(event: Event) -> None:
        with lock:
            observe(event)

    return tell


def both(first: Observer, second: Observer) -> Observer:
    """Return an observer that tells both."""

    def tell(event: Event) -> None:
        first(event)
        second(event)

    return tell


def ignore(event: Event) -> None:
    """An observer for when nobody watches."""
