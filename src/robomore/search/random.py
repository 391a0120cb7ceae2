"""Random search: morphologies drawn around the reference (the paper's "Random Sample")."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import msgspec
import numpy as np

from robomore.designers.designer import Designer
from robomore.errors import InvalidMorphology, NothingTrained
from robomore.identity import derive_seed
from robomore.plan import Plan, Stage
from robomore.search.measure import Evaluate, ranked
from robomore.search.method import SearchContext
from robomore.search.population import pulled, start
from robomore.search.starts import Kind
from robomore.tasks.task import Task
from robomore.tasks.unit_space import UnitSpace
from robomore.types import Design, Evaluation, Morphology, Place, Trial

DRAWS = 2000
"""Draws before one is pulled towards a valid morphology."""

LEAST_SHARE = 0.1
"""A parameter whose reference value is near 0 varies as if it were this fraction of its range."""

STAGE = "samples"
DEVIATION = 0.5
"""Standard deviation of each parameter, as a fraction of its reference value. A half gives about
the coefficient of variation that the paper reports (Table 3)."""


@dataclass(frozen=True, slots=True)
class RandomSettings:
    """Options of the method `random`."""

    samples: Annotated[int, msgspec.Meta(ge=1)] | None = None
    """Morphologies to draw; by default as many as the preset's search has full trainings."""
    deviation: Annotated[float, msgspec.Meta(gt=0)] = DEVIATION
    """Standard deviation of each parameter, as a fraction of its reference value."""


class RandomSearch:
    """Draws morphologies from a Gaussian around the reference, under the reference reward."""

    Settings = RandomSettings
    summary: ClassVar[str] = "morphologies drawn around the reference, under the reference reward"
    needs_designer: ClassVar[bool] = False
    starts_from: ClassVar[tuple[Kind, ...]] = ("morphology",)
    reference_first: ClassVar[bool] = False
    provenance: ClassVar[str] = (
        "No LLM was used: morphologies were drawn at random around the reference design."
    )

    def __init__(self, settings: RandomSettings) -> None:
        self.settings = settings

    def plan(self, context: SearchContext) -> Plan:
        """Return one stage of that many samples."""
        count = self._count(context)
        steps = count * context.candidate.steps
        return Plan(
            (Stage(name=STAGE, axes=("sample",), shape=(count,), evaluations=count, steps=steps),)
        )

    def run(
        self, designer: Designer, evaluate: Evaluate, context: SearchContext
    ) -> list[Evaluation]:
        """Return the trained samples, best first; `designer` is not asked.

        Raises:
            NothingTrained: there is nothing valid to draw around.
        """
        trials = []
        for n in range(self._count(context)):
            seed = derive_seed(context.seed, STAGE, n)
            given = context.starts[n : n + 1]
            morphology = next(iter(given), None) or drawn(
                context.task, seed, self.settings.deviation
            )
            design = Design(morphology, context.reference.reward)
            trials.append(Trial(design, Place(stage=STAGE, index=(n,))))
        return ranked(evaluate(trials), context.objective)

    def _count(self, context: SearchContext) -> int:
        return self.settings.samples or context.evaluations


def drawn(task: Task, seed: int, deviation: float) -> Morphology:
    """Return a valid morphology from a Gaussian around the task's reference, cut at its search
    ranges.

    Where a run's limits refuse the reference, its radii are scaled into them first. If no draw of
    many passes the rules, the last one is pulled towards that until it does.

    Args:
        task: whose parameters these are.
        seed: of the draw.
        deviation: standard deviation, as a fraction of each reference value.

    Raises:
        NothingTrained: there is nothing valid to draw around.
    """
    random = np.random.default_rng(seed)
    task = task.searched()
    anchor = start(task)
    if anchor is None:
        raise NothingTrained(
            f"{task.id}: neither the reference nor any scale of its radii is valid, so there is "
            "nothing to draw around; give larger limits"
        )
    mean = np.array(anchor)
    low = np.array([parameter.low for parameter in task.parameters])
    high = np.array([parameter.high for parameter in task.parameters])
    whole = np.array([parameter.whole for parameter in task.parameters])
    size = deviation * np.maximum(np.abs(mean), LEAST_SHARE * (high - low))
    for _ in range(DRAWS):
        values = random.normal(mean, size)
        values = np.clip(np.where(whole, np.round(values), np.round(values, 5)), low, high)
        try:
            return Morphology(task.check(values.tolist()), "drawn around the reference")
        except InvalidMorphology:
            continue
    space = UnitSpace(task)
    found = pulled(space, space.units(values[None])[0], anchor)
    return Morphology(found, "drawn around the reference, and pulled towards it")
