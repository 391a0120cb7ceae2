"""MAP-Elites (Mouret and Clune 2015): the best morphology for each way to move.

An archive has a cell for each combination of two measures of the gait, and each cell keeps the best
design that moves like that. So the search shows ways to move that a search for the best alone gives
up early.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import msgspec
import numpy as np

from robomore.designers.designer import Designer
from robomore.errors import InputError
from robomore.identity import derive_seed
from robomore.plan import Plan, Stage
from robomore.search.measure import Evaluate, improves, ranked
from robomore.search.method import SearchContext
from robomore.search.population import (
    Array,
    Candidate,
    given_candidate,
    start_candidate,
    trained,
    valid_point,
)
from robomore.search.random import drawn
from robomore.search.starts import Kind
from robomore.tasks.unit_space import UnitSpace
from robomore.types import Evaluation

STAGE = "batches"

RANGES = {
    "ground_contact_share": (0.0, 1.0),
    "joint_amplitude_rad": (0.0, 1.2),
    "stride_frequency_hz": (0.0, 6.0),
}
"""What a cell's axes may measure, and the range that is cut into bins; what lies outside counts to
the outermost bin."""

Descriptor = Literal["ground_contact_share", "joint_amplitude_rad", "stride_frequency_hz"]


@dataclass(frozen=True, slots=True)
class MapElitesSettings:
    """Options of the method `map-elites`."""

    evaluations: Annotated[int, msgspec.Meta(ge=1)] | None = None
    """Morphologies to train; by default as many as the preset's search has full trainings."""
    initial: Annotated[int, msgspec.Meta(ge=1)] | None = None
    """Morphologies before any is changed: the reference and draws around it. By default a quarter
    of the evaluations."""
    batch: Annotated[int, msgspec.Meta(ge=1)] = 4
    """Morphologies that are trained side by side before the archive is looked at again."""
    descriptors: tuple[Descriptor, Descriptor] = ("stride_frequency_hz", "joint_amplitude_rad")
    """The two measures of the gait that span the archive. They are measured in the trusted process,
    where no reward is loaded."""
    bins: Annotated[int, msgspec.Meta(ge=1, le=100)] = 6
    """Cells along each of the two."""
    mutation: Annotated[float, msgspec.Meta(gt=0, le=1)] = 0.05
    """Standard deviation of a change of each parameter, as a fraction of its range."""
    line: Annotated[float, msgspec.Meta(ge=0, le=1)] = 0.3
    """Standard deviation of a step along the line to another elite, as a fraction of the way."""
    deviation: Annotated[float, msgspec.Meta(gt=0)] = 0.5
    """Standard deviation of the first draws around the reference, as a fraction of each
    reference value."""


class MapElites:
    """A grid archive over gaits, filled by changes of its elites, under the reference reward.

    Args:
        settings: how much is trained, and what the cells are.

    Raises:
        InputError: both measures are the same one.
    """

    Settings = MapElitesSettings
    summary: ClassVar[str] = "MAP-Elites: the best morphology for each gait, reference reward"
    needs_designer: ClassVar[bool] = False
    starts_from: ClassVar[tuple[Kind, ...]] = ("morphology",)
    provenance: ClassVar[str] = (
        "No LLM was used: morphologies were changed at random by MAP-Elites, starting at the "
        "reference design."
    )

    def __init__(self, settings: MapElitesSettings) -> None:
        first, second = settings.descriptors
        if first == second:
            others = ", ".join(name for name in RANGES if name != first)
            raise InputError(
                f"descriptors = {list(settings.descriptors)} is one measure twice, and no grid; "
                f"choose another one beside it: {others}"
            )
        self.settings = settings

    def plan(self, context: SearchContext) -> Plan:
        """Return one stage with a batch for the first draws, and then one for each look."""
        count, initial = self._sizes(context)
        steps = count * context.candidate.steps
        return Plan(
            (
                Stage(
                    name=STAGE,
                    axes=("sample",),
                    shape=(count,),
                    evaluations=count,
                    steps=steps,
                    batches=1 + math.ceil((count - initial) / self.settings.batch),
                ),
            )
        )

    def run(
        self, designer: Designer, evaluate: Evaluate, context: SearchContext
    ) -> list[Evaluation]:
        """Return the trained morphologies, best first; `designer` is not asked."""
        count, size = self._sizes(context)
        found: list[Evaluation] = []
        while len(found) < count:
            # Until something moves in a measurable way, whatever was trained can be a parent.
            elites = list(archive(found, self.settings, context.objective).values())
            elites = elites or ranked(found, context.objective)
            places = [(n,) for n in range(len(found), min(len(found) + size, count))]
            candidates = [self._candidate(n, elites, context) for (n,) in places]
            found += trained(evaluate, candidates, places, STAGE, context)
            size = self.settings.batch
        return ranked(found, context.objective)

    def _sizes(self, context: SearchContext) -> tuple[int, int]:
        """Return how many morphologies are trained, and how many of them in the first batch."""
        count = self.settings.evaluations or context.evaluations
        return count, min(count, self.settings.initial or max(1, math.ceil(count / 4)))

    def _candidate(
        self, number: int, elites: Sequence[Evaluation], context: SearchContext
    ) -> Candidate:
        seed = derive_seed(context.seed, STAGE, number)
        if given := given_candidate(number, context):
            return given
        if not elites:
            if number == 0:
                return start_candidate(context)
            morphology = drawn(context.task, seed, self.settings.deviation)
            return Candidate(morphology.parameters, morphology.idea)
        random = np.random.default_rng(seed)
        space = UnitSpace(context.task)
        parent, other = (elites[index] for index in random.integers(len(elites), size=2))
        one, two = space.units([e.design.morphology.parameters for e in (parent, other)])

        def draw() -> Array:
            # The operator "Iso+LineDD" (Vassiliades and Mouret 2018).
            step = random.normal(0, self.settings.mutation, space.size)
            moved: Array = one + step + random.normal(0, self.settings.line) * (two - one)
            return moved

        values = valid_point(space, draw, parent.design.morphology.parameters)
        return Candidate(values, "a change of an elite", parent=parent.key)


def archive(
    evaluations: Sequence[Evaluation], settings: MapElitesSettings, objective: str
) -> dict[tuple[int, int], Evaluation]:
    """Return the best evaluation of each cell that any of them moves in.

    Args:
        evaluations: failures, and those without the measures, fill no cell.
        settings: what the cells are.
        objective: what the best is best in.
    """
    cells: dict[tuple[int, int], Evaluation] = {}
    for evaluation in evaluations:
        cell = cell_of(evaluation, settings)
        if cell is None or evaluation.score(objective) is None:
            continue
        if cell not in cells or improves(evaluation, cells[cell], objective):
            cells[cell] = evaluation
    return cells


def cell_of(evaluation: Evaluation, settings: MapElitesSettings) -> tuple[int, int] | None:
    """Return the cell that an evaluation's gait belongs to; `None` where it was not measured."""

    def index(name: Descriptor) -> int:
        low, high = RANGES[name]
        share = (evaluation.behaviour[name] - low) / (high - low)
        return min(max(math.floor(share * settings.bins), 0), settings.bins - 1)

    first, second = settings.descriptors
    if first not in evaluation.behaviour or second not in evaluation.behaviour:
        return None
    return index(first), index(second)
