"""CMA-ES over the task's bounds: a Gaussian that learns where good morphologies are."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar

import msgspec
import numpy as np

from robomore.designers.designer import Designer
from robomore.identity import derive_seed
from robomore.plan import Plan
from robomore.search.measure import Evaluate, ranked
from robomore.search.method import SearchContext
from robomore.search.population import (
    Array,
    Candidate,
    accepted,
    generations,
    given_candidate,
    start_candidate,
    trained,
    valid_point,
)
from robomore.search.starts import Kind
from robomore.tasks.unit_space import UnitSpace
from robomore.types import Evaluation

if TYPE_CHECKING:
    import cmaes

STAGE = "generations"

MARGIN = 0.1
"""How far points may lie outside of the unit cube. They are trained at its edge. So a best value at
a bound, where radii often have it, lies well within what is sampled."""

_FEWEST_GENERATIONS = 6
"""Generations that a small budget is split into, at the cost of the population's size."""

_SMALLEST = 4
"""Smallest population from which CMA-ES learns anything."""


@dataclass(frozen=True, slots=True)
class CMAESSettings:
    """Options of the method `cmaes`."""

    evaluations: Annotated[int, msgspec.Meta(ge=1)] | None = None
    """Morphologies to train; by default as many as the preset's search has full trainings."""
    population: Annotated[int, msgspec.Meta(ge=4)] | None = None
    """Morphologies in a generation; by default 4 + 3 ln(parameters), and fewer where the budget
    would give less than six generations."""
    sigma: Annotated[float, msgspec.Meta(gt=0, le=1)] = 0.2
    """First standard deviation, as a fraction of each parameter's range."""


class CMAES:
    """CMA-ES (Hansen 2016; the package `cmaes`) from the reference, under the reference reward."""

    Settings = CMAESSettings
    summary: ClassVar[str] = "CMA-ES over the task's bounds, under the reference reward"
    needs_designer: ClassVar[bool] = False
    starts_from: ClassVar[tuple[Kind, ...]] = ("morphology",)
    reference_first: ClassVar[bool] = False
    provenance: ClassVar[str] = (
        "No LLM was used: morphologies were sampled by CMA-ES, starting at the reference design."
    )

    def __init__(self, settings: CMAESSettings) -> None:
        self.settings = settings

    def plan(self, context: SearchContext) -> Plan:
        """Return one stage of so many generations."""
        return generations(STAGE, *self._sizes(context), context)

    def run(
        self, designer: Designer, evaluate: Evaluate, context: SearchContext
    ) -> list[Evaluation]:
        """Return the trained morphologies, best first; `designer` is not asked."""
        space = UnitSpace(context.task)
        count, size = self._sizes(context)
        anchor = start_candidate(context).parameters
        if context.starts:
            anchor = context.starts[0].parameters
        sampler = self._sampler(space, anchor, size, context.seed, 0)
        found: list[Evaluation] = []
        for generation in range(math.ceil(count / size)):
            if sampler.should_stop():
                # It has converged. What is left of the budget begins again around the best.
                sampler = self._sampler(space, anchor, size, context.seed, generation)
            points, candidates = [], []
            for member in range(min(size, count - len(found))):
                given = given_candidate(generation * size + member + 1, context)
                if given is not None:
                    points.append(space.units([given.parameters])[0])
                    candidates.append(given)
                    continue
                point, values = _asked(sampler, space, anchor)
                points.append(point)
                candidates.append(Candidate(values, f"CMA-ES, generation {generation + 1}"))
            places = [(generation, member) for member in range(len(candidates))]
            measured = trained(evaluate, candidates, places, STAGE, context)
            found += measured
            if best := ranked(found, context.objective):
                anchor = best[0].design.morphology.parameters
            if len(points) == size:
                sampler.tell(
                    [
                        (point, _loss(evaluation, context.objective))
                        for point, evaluation in zip(points, measured, strict=True)
                    ]
                )
        return ranked(found, context.objective)

    def _sampler(
        self, space: UnitSpace, around: tuple[float, ...], size: int, seed: int, restart: int
    ) -> cmaes.CMA:
        # Imported here, since listing the methods needs no CMA-ES, which loads SciPy.
        import cmaes

        return cmaes.CMA(
            mean=space.units([around])[0],
            sigma=self.settings.sigma,
            bounds=np.tile([-MARGIN, 1 + MARGIN], (space.size, 1)),
            seed=derive_seed(seed, STAGE, restart),
            population_size=size,
        )

    def _sizes(self, context: SearchContext) -> tuple[int, int]:
        """Return how many morphologies are trained, and how many of them in a generation."""
        count = self.settings.evaluations or context.evaluations
        usual = 4 + math.floor(3 * math.log(len(context.task.parameters)))
        size = self.settings.population or max(_SMALLEST, min(usual, count // _FEWEST_GENERATIONS))
        return count, size


def _asked(
    sampler: cmaes.CMA, space: UnitSpace, anchor: tuple[float, ...]
) -> tuple[Array, tuple[float, ...]]:
    """Return a point of the sampler, and the valid values that are trained for it.

    Where no sample is valid, the point is where the values lie: the sampler learns from what was
    trained, and does not walk on into what the task refuses.
    """
    asked: list[Array] = []

    def draw() -> Array:
        asked.append(sampler.ask())
        return asked[-1]

    values = valid_point(space, draw, anchor)
    if accepted(space, asked[-1]) is None:
        return space.units([values])[0], values
    return asked[-1], values


def _loss(evaluation: Evaluation, objective: str) -> float:
    """Return what CMA-ES minimises; it compares ranks alone, and a failure is the worst."""
    score = evaluation.score(objective)
    return math.inf if score is None else -score
