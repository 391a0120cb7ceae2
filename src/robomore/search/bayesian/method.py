"""Bayesian optimisation (the paper's baseline): learn fitness, know the volume, try the best bet.

Efficiency is fitness over volume, and the volume of a morphology is known exactly. So the Gaussian
process learns the log of the fitness alone, and the log volume is subtracted.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from functools import partial
from typing import Annotated, ClassVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from robomore.designers.designer import Designer
from robomore.errors import NothingTrained
from robomore.identity import derive_seed
from robomore.plan import Plan, Stage
from robomore.search.bayesian.process import Array, fitted, log_expected_improvement
from robomore.search.measure import Evaluate, ranked
from robomore.search.method import SearchContext
from robomore.search.population import (
    Candidate,
    start_candidate,
    trained,
    valid_point,
)
from robomore.search.starts import Kind
from robomore.tasks.unit_space import UnitSpace
from robomore.types import Evaluation

STAGE = "points"

FLOOR = 0.02
"""A failure, and any fitness below this fraction of the best one, counts as this fraction of it, so
that its logarithm is finite."""

POOL = 250
"""Points anywhere, and points near the best one, that are compared first."""

REFINED, ROUNDS = 5, 5
"""The best of the pool are moved by smaller and smaller steps, so many times."""


@dataclass(frozen=True, slots=True)
class BayesianSettings:
    """Options of the method `bayesian`."""

    evaluations: Annotated[int, msgspec.Meta(ge=1)] | None = None
    """Morphologies to train; by default as many as the preset's search has full trainings."""
    initial: Annotated[int, msgspec.Meta(ge=2)] | None = None
    """Morphologies before the model is asked: the reference, and points spread over the task's
    bounds. By default a quarter of the evaluations."""
    batch: Annotated[int, msgspec.Meta(ge=1)] = 2
    """Morphologies that are chosen together and trained side by side. One learns the most from each
    training; more keep more cores busy."""


class Bayesian:
    """A Gaussian process of log fitness, and log expected improvement over the task's bounds."""

    Settings = BayesianSettings
    summary: ClassVar[str] = "Bayesian optimisation of the morphology, under the reference reward"
    needs_designer: ClassVar[bool] = False
    starts_from: ClassVar[tuple[Kind, ...]] = ("morphology",)
    provenance: ClassVar[str] = (
        "No LLM was used: morphologies were chosen by Bayesian optimisation over the task's bounds."
    )

    def __init__(self, settings: BayesianSettings) -> None:
        self.settings = settings

    def plan(self, context: SearchContext) -> Plan:
        """Return one stage with a batch for the first points, and then one for each choice."""
        count, initial = self._sizes(context)
        batches = 1 + math.ceil((count - initial) / self.settings.batch)
        steps = count * context.candidate.steps
        return Plan(
            (
                Stage(
                    name=STAGE,
                    axes=("point",),
                    shape=(count,),
                    evaluations=count,
                    steps=steps,
                    batches=batches,
                ),
            )
        )

    def run(
        self, designer: Designer, evaluate: Evaluate, context: SearchContext
    ) -> list[Evaluation]:
        """Return the trained morphologies, best first; `designer` is not asked."""
        space = UnitSpace(context.task)
        count, initial = self._sizes(context)
        initial = max(initial, 1 + len(context.starts))
        found = self._trained(evaluate, _first(space, initial, context), 0, context)
        while len(found) < count:
            size = min(self.settings.batch, count - len(found))
            candidates = _chosen(space, found, size, context)
            found += self._trained(evaluate, candidates, len(found), context)
        return ranked(found, context.objective)

    def _trained(
        self,
        evaluate: Evaluate,
        candidates: Sequence[Candidate],
        first: int,
        context: SearchContext,
    ) -> list[Evaluation]:
        places = [(first + n,) for n in range(len(candidates))]
        return trained(evaluate, candidates, places, STAGE, context)

    def _sizes(self, context: SearchContext) -> tuple[int, int]:
        """Return how many morphologies are trained, and how many of them before the model."""
        count = self.settings.evaluations or context.evaluations
        return count, min(count, self.settings.initial or max(2, math.ceil(count / 4)))


def _first(space: UnitSpace, count: int, context: SearchContext) -> list[Candidate]:
    """Return the reference, and points spread over the bounds as far as the rules let them."""
    random = np.random.default_rng(derive_seed(context.seed, STAGE, "first"))
    # A Latin hypercube: each range is cut into slices, and each slice is used once.
    rest = count - 1 - len(context.starts)
    slices = np.stack([random.permutation(rest) for _ in range(space.size)], axis=1)
    begin = start_candidate(context)
    candidates = [begin, *(Candidate(one.parameters, one.idea) for one in context.starts)]
    for cell in slices:
        draw = partial(_within, cell, rest, random)
        values = valid_point(space, draw, begin.parameters)
        candidates.append(Candidate(values, "a first point, spread over the bounds"))
    return candidates


def _within(cell: NDArray[np.int64], slices: int, random: np.random.Generator) -> Array:
    point: Array = (cell + random.random(len(cell))) / slices
    return point


def _chosen(
    space: UnitSpace, found: Sequence[Evaluation], size: int, context: SearchContext
) -> list[Candidate]:
    """Return the points with the largest expected improvement, one after the other.

    For each further point of a batch, the ones before it count as measured, with the value that the
    model expects of them (Ginsbourger et al. 2010: kriging believer).
    """
    random = np.random.default_rng(derive_seed(context.seed, STAGE, len(found)))
    values = np.array([e.design.morphology.parameters for e in found])
    learned = _learned(space, values, found, context.objective)
    chosen: list[Candidate] = []
    for _ in range(size):
        model = _Model(space, values, learned, context.objective)
        parameters = _most_promising(model, random)
        chosen.append(Candidate(parameters, "the largest expected improvement"))
        new = np.array([parameters])
        learned = np.append(learned, model.fitness(new)[0])
        values = np.vstack((values, new))
    return chosen


class _Model:
    """What is expected of morphologies, given the log fitness of those that were trained."""

    def __init__(self, space: UnitSpace, values: Array, learned: Array, objective: str) -> None:
        self.space, self.values = space, values
        self._objective = objective
        self._mean, self._spread = float(learned.mean()), max(float(learned.std()), 1e-6)
        self._process = fitted(space.units(values), (learned - self._mean) / self._spread)
        # The best is what the model believes, not the luckiest measurement.
        believed = self.fitness(values)[0] + known_part(space, values, objective)
        self._best = float(believed.max())
        self.best_point: Array = space.units(values[[int(np.argmax(believed))]])[0]

    def fitness(self, values: Array) -> tuple[Array, Array]:
        """Return mean and deviation (m,) of the log fitness of morphologies (m, size)."""
        mean, deviation = self._process.predict(self.space.units(values))
        return self._mean + self._spread * mean, self._spread * deviation

    def promise(self, values: Array) -> Array:
        """Return the log expected improvement (m,) of the log score of morphologies (m, size)."""
        mean, deviation = self.fitness(values)
        mean = mean + known_part(self.space, values, self._objective)
        return log_expected_improvement(mean, deviation, self._best)


def _most_promising(model: _Model, random: np.random.Generator) -> tuple[float, ...]:
    """Return the valid new morphology with the largest expected improvement that was found."""
    space = model.space
    tried = {tuple(row) for row in model.values.tolist()}
    anywhere = random.random((POOL, space.size))
    step = random.normal(0, 1, (POOL, space.size)) * 10 ** random.uniform(-2, -0.5, (POOL, 1))
    moved = random.random((POOL, space.size)) < random.uniform(1 / space.size, 1, (POOL, 1))
    near = model.best_point + np.where(moved, step, 0)
    values, worth = _rated(model, np.vstack((anywhere, near)), tried)
    for number in range(ROUNDS):
        best = np.argsort(-worth, kind="stable")[:REFINED]
        around = np.repeat(space.units(values[best]), REFINED, axis=0)
        steps = random.normal(0, 0.1 * 0.5**number, around.shape)
        refined, refined_worth = _rated(model, around + steps, tried)
        values = np.vstack((values[best], refined))
        worth = np.append(worth[best], refined_worth)
    if not len(values):
        raise NothingTrained(
            f"{space.task.id}: no valid morphology was found that is not trained yet; give a "
            "smaller --evaluations"
        )
    return tuple(values[int(np.argmax(worth))].tolist())


def _rated(
    model: _Model, points: Array, tried: AbstractSet[tuple[float, ...]]
) -> tuple[Array, Array]:
    """Return the valid new ones of `points` as values, and their promise."""
    values = model.space.values(points)
    new = np.array([tuple(row) not in tried for row in values.tolist()], dtype=bool)
    values = values[new & model.space.valid(values)]
    return values, model.promise(values) if len(values) else np.empty(0)


def _learned(space: UnitSpace, values: Array, found: Sequence[Evaluation], objective: str) -> Array:
    """Return the log score (n,) of trained morphologies without its known part: the log fitness,
    where efficiency is compared. Where fitness may be below 0, it is the score as it is."""
    scores = [e.score(objective) for e in found]
    if space.task.goal.may_be_negative:
        worst = min((score for score in scores if score is not None), default=0.0)
        return np.array([worst if score is None else score for score in scores])
    measured = np.array([0.0 if score is None else score for score in scores])
    fitness = measured * np.exp(-known_part(space, values, objective))
    floor = FLOOR * max(float(fitness.max()), 1e-9)
    learned: Array = np.log(np.maximum(fitness, floor))
    return learned


def known_part(space: UnitSpace, values: Array, objective: str) -> Array:
    """Return the part (n,) of the log score that needs no training: less the log volume."""
    if objective == "efficiency":
        less: Array = -np.log(space.volumes(values))
        return less
    return np.zeros(len(values))
