"""What a search method is: settings, a plan, and straight-line code that returns the best first."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, TypeVar

from robomore.designers.designer import Designer
from robomore.events import Observer, ignore
from robomore.plan import Plan
from robomore.search.measure import Evaluate
from robomore.settings import Budget, Objective
from robomore.tasks.task import Task
from robomore.types import Design, Evaluation, Morphology

T = TypeVar("T")


class MapFn(Protocol):
    """Makes calls that do not depend on each other, in turn or side by side."""

    def __call__(self, calls: Sequence[Callable[[], T]], /) -> list[T]:
        """Return what the calls return, in their order."""
        ...


def sequential_map(calls: Sequence[Callable[[], T]], /) -> list[T]:
    """Make one call after the other."""
    return [call() for call in calls]


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchContext:
    """What a method may know of the run.

    Attributes:
        task: what is to be done: parameters, bounds, rules, volume.
        reference: the reference morphology under the reference reward.
        candidate: budget of one evaluation in full.
        evaluations: about how many full trainings the search may use, for methods that have no
            sizes of their own.
        objective: what is compared, `efficiency` or `fitness`.
        seed: of the run; whatever is drawn at random follows from it.
        observe: told what goes on, such as who is cut.
        map_fn: asks for proposals that do not depend on each other.
        starts: given morphologies that a method without a designer tries first. A designer proposes
            them by itself.
    """

    task: Task
    reference: Design
    candidate: Budget
    evaluations: int
    objective: Objective = "efficiency"
    seed: int = 0
    observe: Observer = ignore
    map_fn: MapFn = sequential_map
    starts: tuple[Morphology, ...] = ()


class SearchMethod(Protocol):
    """Decides what is tried. Made with an instance of its own `Settings`.

    The same settings, context, proposals and measurements give the same search. A method keeps no
    files and no clock: whatever it has asked for before is answered from the ledger, so a run is
    resumed by running it again.

    Attributes:
        Settings: frozen dataclass of the method's options, all with defaults.
        summary: one line for `robomore methods`.
        needs_designer: whether it asks a designer for proposals.
        provenance: one sentence on where its designs come from; empty where the designer says it.

    A method that can start from given designs says so with `starts_from`, a tuple of `morphology`
    and `reward`. One without it takes none. Without a designer it is taken to train the reference
    before them, unless `reference_first` is false. A method that tries designs which its designer
    did not propose says so with `adds`, a sentence.
    """

    Settings: ClassVar[type[Any]]
    summary: ClassVar[str]
    needs_designer: ClassVar[bool]
    provenance: ClassVar[str]

    def __init__(self, settings: Any) -> None: ...

    def plan(self, context: SearchContext) -> Plan:
        """Return the stages, and the most that each may ask for.

        Raises:
            InputError: the settings make no sense together.
        """
        ...

    def run(
        self, designer: Designer, evaluate: Evaluate, context: SearchContext
    ) -> list[Evaluation]:
        """Search, and return what was trained to the end, best first.

        A bad design raises nothing: its evaluation has failed. `evaluate` may end the search from
        inside when a budget is spent; the best so far is then kept for it.

        Raises:
            NothingTrained: no design could be trained.
        """
        ...
