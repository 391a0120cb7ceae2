"""A search method in one file: change one parameter at a time, keep what is better.

Install this folder (`pip install examples/hill-climb`), and then:

    robomore run swimmer --preset quick --method hill-climb --method-option step=0.3
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import msgspec
import numpy as np

from robomore.errors import InvalidMorphology
from robomore.identity import derive_seed
from robomore.plan import Plan, Stage
from robomore.search.measure import Evaluate, improves, ranked
from robomore.search.method import SearchContext
from robomore.types import Design, Evaluation, Morphology, Place, Trial


@dataclass(frozen=True, slots=True)
class HillClimbSettings:
    """Options of the method `hill-climb`."""

    neighbours: Annotated[int, msgspec.Meta(ge=1)] = 2
    """Designs that are tried in each round, side by side."""
    step: Annotated[float, msgspec.Meta(gt=0, lt=1)] = 0.2
    """Largest change of a parameter, as a share of its value."""


class HillClimb:
    """Starts from the reference design; each round tries some neighbours of the best so far."""

    Settings = HillClimbSettings
    summary = "change one parameter at a time, keep what is better"
    needs_designer = False
    provenance = "No LLM was used: one parameter was changed at a time, at random."

    def __init__(self, settings: HillClimbSettings) -> None:
        self.settings = settings

    def plan(self, context: SearchContext) -> Plan:
        """Return one stage: rounds of neighbours, as many as the preset has trainings."""
        rounds, each = self._rounds(context), self.settings.neighbours
        count = 1 + rounds * each
        return Plan(
            (
                Stage(
                    name="climb",
                    axes=("round", "neighbour"),
                    shape=(rounds + 1, each),
                    evaluations=count,
                    steps=count * context.candidate.steps,
                    batches=rounds + 1,
                ),
            )
        )

    def run(self, designer: object, evaluate: Evaluate, context: SearchContext) -> list[Evaluation]:
        """Return everything that was tried, best first."""
        (best,) = tried = evaluate([Trial(context.reference, Place(stage="climb", index=(0, 0)))])
        for number in range(1, self._rounds(context) + 1):
            trials = [
                Trial(
                    Design(self._near(best, number, i, context), best.design.reward),
                    Place(stage="climb", index=(number, i), changed="morphology", parent=best.key),
                )
                for i in range(self.settings.neighbours)
            ]
            measured = evaluate(trials)
            tried += measured
            for one in measured:
                if improves(one, best, context.objective):
                    best = one
        distinct = {evaluation.key: evaluation for evaluation in tried}
        return ranked(distinct.values(), context.objective)

    def _rounds(self, context: SearchContext) -> int:
        return max(1, (context.evaluations - 1) // self.settings.neighbours)

    def _near(self, best: Evaluation, number: int, i: int, context: SearchContext) -> Morphology:
        random = np.random.default_rng(derive_seed(context.seed, "climb", number, i))
        task, values = context.task, list(best.design.morphology.parameters)
        for _ in range(1000):
            changed = int(random.integers(len(values)))
            name = task.parameters[changed].name
            near = list(values)
            near[changed] *= 1 + random.uniform(-self.settings.step, self.settings.step)
            try:
                return Morphology(task.check(near), f"another {name}")
            except InvalidMorphology:
                continue
        return best.design.morphology
