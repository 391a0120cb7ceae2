"""A genetic algorithm over morphologies (the paper's "evolutionary algorithm")."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar

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
    generations,
    given_candidate,
    start_candidate,
    trained,
    valid_point,
)
from robomore.search.random import drawn
from robomore.search.starts import Kind
from robomore.tasks.task import Task
from robomore.tasks.unit_space import UnitSpace
from robomore.types import Evaluation

STAGE = "generations"


@dataclass(frozen=True, slots=True)
class GeneticSettings:
    """Options of the method `genetic`."""

    evaluations: Annotated[int, msgspec.Meta(ge=1)] | None = None
    """Morphologies to train; by default as many as the preset's search has full trainings."""
    population: Annotated[int, msgspec.Meta(ge=2)] = 8
    """Morphologies in a generation; the best of all so far are the parents of the next one."""
    tournament: Annotated[int, msgspec.Meta(ge=1)] = 3
    """Parents drawn at random, of which the best one has the child."""
    crossover: Annotated[float, msgspec.Meta(ge=0, le=1)] = 0.8
    """Probability that a child has a second parent, and each limb from either of them."""
    mutation: Annotated[float, msgspec.Meta(gt=0, le=1)] = 0.1
    """Standard deviation of a mutation, as a fraction of each parameter's range."""
    deviation: Annotated[float, msgspec.Meta(gt=0)] = 0.5
    """Standard deviation of the first generation around the reference, as a fraction of each
    reference value; the reference itself is in it."""


class Genetic:
    """Tournaments, crossover of whole limbs, and mutation, under the reference reward."""

    Settings = GeneticSettings
    summary: ClassVar[str] = "a genetic algorithm over limbs, under the reference reward"
    needs_designer: ClassVar[bool] = False
    starts_from: ClassVar[tuple[Kind, ...]] = ("morphology",)
    provenance: ClassVar[str] = (
        "No LLM was used: morphologies were bred by a genetic algorithm from the reference design."
    )

    def __init__(self, settings: GeneticSettings) -> None:
        self.settings = settings

    def plan(self, context: SearchContext) -> Plan:
        """Return one stage of so many generations."""
        return generations(STAGE, self._count(context), self.settings.population, context)

    def run(
        self, designer: Designer, evaluate: Evaluate, context: SearchContext
    ) -> list[Evaluation]:
        """Return the trained morphologies, best first; `designer` is not asked."""
        size = self.settings.population
        found: list[Evaluation] = []
        for first in range(0, self._count(context), size):
            generation = first // size
            places = [(generation, n) for n in range(min(size, self._count(context) - first))]
            parents = ranked(found, context.objective)[:size]
            candidates = [self._member(place, parents, context) for place in places]
            found += trained(evaluate, candidates, places, STAGE, context)
        return ranked(found, context.objective)

    def _count(self, context: SearchContext) -> int:
        return self.settings.evaluations or context.evaluations

    def _member(
        self, place: tuple[int, int], parents: Sequence[Evaluation], context: SearchContext
    ) -> Candidate:
        """Return a child of two of `parents`; without parents, a draw around the reference."""
        seed = derive_seed(context.seed, STAGE, place)
        if given := given_candidate(place[0] * self.settings.population + place[1], context):
            return given
        if not parents:
            if place == (0, 0):
                return start_candidate(context)
            morphology = drawn(context.task, seed, self.settings.deviation)
            return Candidate(morphology.parameters, morphology.idea)
        random = np.random.default_rng(seed)
        space = UnitSpace(context.task)
        mother, father = (self._chosen(parents, random) for _ in range(2))
        one, other = space.units([p.design.morphology.parameters for p in (mother, father)])
        crossed = mother is not father and random.random() < self.settings.crossover
        limbs = limbs_of(context.task)

        def draw() -> Array:
            child: Array = one.copy()
            for limb in limbs:
                if crossed and random.random() < 0.5:
                    child[limb] = other[limb]
            # One parameter of each limb in the mean; at least one in all.
            mutated = random.random(space.size) < len(limbs) / space.size
            mutated[random.integers(space.size)] = True
            step: Array = random.normal(0, self.settings.mutation, space.size)
            child[mutated] += step[mutated]
            return child

        values = valid_point(space, draw, mother.design.morphology.parameters)
        idea = "limbs of two parents, mutated" if crossed else "mutation of one parent"
        return Candidate(values, idea, parent=mother.key)

    def _chosen(self, parents: Sequence[Evaluation], random: np.random.Generator) -> Evaluation:
        """Return the winner of a tournament; `parents` stand best first."""
        return parents[int(random.integers(len(parents), size=self.settings.tournament).min())]


def limbs_of(task: Task) -> list[list[int]]:
    """Return the parameters of each limb by number: names that differ in their last word alone.

    `back_shin_x`, `back_shin_z` and `back_shin_radius` belong to one limb, so that a crossover does
    not tear it apart.
    """
    limbs: dict[str, list[int]] = {}
    for index, name in enumerate(task.names):
        limbs.setdefault(name.rpartition("_")[0] or name, []).append(index)
    return list(limbs.values())
