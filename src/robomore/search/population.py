"""What methods share that search morphologies as points of the unit cube of a task's bounds.

They all train under the reference reward, start from the reference morphology, and propose within
the task's rules: a point that breaks a rule is drawn anew, and in the end pulled towards a valid
one, so that no training is spent on what the task refuses.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robomore.errors import InvalidMorphology, NothingTrained
from robomore.plan import Plan, Stage
from robomore.search.measure import Evaluate
from robomore.search.method import SearchContext
from robomore.tasks.task import Task
from robomore.tasks.unit_space import DECIMALS, UnitSpace
from robomore.types import Design, Evaluation, Morphology, Place, Trial

Array = NDArray[np.float64]

DRAWS = 100
"""Draws before a point is pulled towards a valid one."""

_SCALES = 401
"""Scales of the radii that are tried, 1 among them."""

_HALVINGS = 20
"""Steps of the bisection between a valid and an invalid point."""


@dataclass(frozen=True, slots=True)
class Candidate:
    """A morphology to train.

    Attributes:
        parameters: valid values in the task's order.
        idea: where it comes from, in a few words.
        parent: key of the evaluation that it was made from; empty for a first idea.
    """

    parameters: tuple[float, ...]
    idea: str
    parent: str = ""


def valid_point(
    space: UnitSpace, draw: Callable[[], Array], anchor: Sequence[float]
) -> tuple[float, ...]:
    """Return valid parameter values from `draw`.

    Args:
        space: the task's unit cube.
        draw: returns a new point (size,) each time.
        anchor: valid values that the last draw is pulled towards if no draw is valid.
    """
    for _ in range(DRAWS):
        point = draw()
        if (found := accepted(space, point)) is not None:
            return found
    return pulled(space, point, anchor)


def pulled(space: UnitSpace, point: Array, anchor: Sequence[float]) -> tuple[float, ...]:
    """Return the values nearest to `point` (size,) on the way to `anchor` that the task accepts."""
    start = space.units([anchor])[0]
    low, high, best = 0.0, 1.0, tuple(anchor)
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        found = accepted(space, start + middle * (point - start))
        if found is None:
            high = middle
        else:
            low, best = middle, found
    return best


def accepted(space: UnitSpace, point: Array) -> tuple[float, ...] | None:
    """Return the values at `point` (size,), or `None` if the task refuses them."""
    try:
        return space.task.check(space.values(point[None])[0].tolist())
    except InvalidMorphology:
        return None


def start(task: Task, *, drawn_around: bool = False) -> tuple[float, ...] | None:
    """Return the reference, or the reference at the nearest scale of its radii that is valid.

    A run's limits may refuse the reference itself. Scales within the search ranges go before those
    within the task's own bounds.

    Args:
        task: with a run's limits among its rules.
        drawn_around: whether morphologies are drawn around it, which takes the search ranges.

    Returns:
        `None` where they refuse every scale.
    """
    try:
        return task.check(task.reference)
    except InvalidMorphology:
        pass
    radii, reference = UnitSpace(task).radii, np.array(task.reference)
    scales = sorted(np.geomspace(1e-2, 1e2, _SCALES), key=lambda one: abs(math.log(one)))
    for bounded in (task.searched(),) if drawn_around else (task.searched(), task):
        for scale in scales:
            values = np.where(radii, np.round(scale * reference, DECIMALS), reference)
            try:
                return bounded.check(values.tolist())
            except InvalidMorphology:
                continue
    return None


def kept_morphology(context: SearchContext) -> Morphology:
    """Return the morphology of a search that keeps the reference's: within the run's limits.

    Raises:
        NothingTrained: no scale of the reference's radii is within them.
    """
    begin = start_candidate(context)
    if begin.parameters == context.task.reference:
        return context.reference.morphology
    return Morphology(begin.parameters, begin.idea)


def start_candidate(context: SearchContext) -> Candidate:
    """Return what these methods start from: the reference, if the run's limits allow it."""
    begin = start(context.task)
    if begin == context.task.reference:
        return Candidate(begin, "the reference design")
    if begin is None:
        raise NothingTrained(
            f"{context.task.id}: no scale of the reference's radii is valid; give larger limits"
        )
    return Candidate(begin, "the reference with its radii scaled into the run's limits")


def given_candidate(number: int, context: SearchContext) -> Candidate | None:
    """Return the given start that is candidate `number` of a search, the reference being 0."""
    if not 1 <= number <= len(context.starts):
        return None
    start = context.starts[number - 1]
    return Candidate(start.parameters, start.idea)


def generations(stage: str, count: int, size: int, context: SearchContext) -> Plan:
    """Return a plan of one stage in which `count` morphologies are trained, `size` at a time."""
    number = math.ceil(count / size)
    return Plan(
        (
            Stage(
                name=stage,
                axes=("generation", "member"),
                shape=(number, size),
                evaluations=count,
                steps=count * context.candidate.steps,
                batches=number,
            ),
        )
    )


def trained(
    evaluate: Evaluate,
    candidates: Sequence[Candidate],
    places: Sequence[tuple[int, ...]],
    stage: str,
    context: SearchContext,
) -> list[Evaluation]:
    """Return one evaluation for each candidate under the reference reward, in order.

    Args:
        evaluate: measures a batch.
        candidates: what is trained.
        places: index of each in the stage.
        stage: name of the stage in the plan.
        context: of the search.
    """
    trials = [
        Trial(
            Design(Morphology(one.parameters, one.idea), context.reference.reward),
            Place(
                stage=stage,
                index=place,
                changed="morphology" if one.parent else "",
                parent=one.parent,
            ),
        )
        for one, place in zip(candidates, places, strict=True)
    ]
    return evaluate(trials)
