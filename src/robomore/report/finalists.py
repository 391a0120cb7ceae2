"""Two designs next to each other: the champion and the human one, each over its training seeds."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from robomore.report.metrics import Spread, spread
from robomore.tasks import Task
from robomore.types import Design, Evaluation, Place


@dataclass(frozen=True, slots=True)
class Contestant:
    """One design and everything that was measured of it with one budget.

    Attributes:
        name: `champion`, `best so far` or `human`.
        design: body and reward.
        parameters: by name.
        volume: in m^3.
        fitness: over the seeds that trained, in m; `None` if none did.
        efficiency: likewise, in m/m^3.
        body: `mass` kg, `density` kg/m^3, `rest_height` m, as far as known.
        evaluations: one for each training seed, failed ones too.
    """

    name: str
    design: Design
    parameters: dict[str, float]
    volume: float
    fitness: Spread | None
    efficiency: Spread | None
    body: dict[str, float]
    evaluations: tuple[Evaluation, ...]

    @property
    def trained(self) -> tuple[Evaluation, ...]:
        """The evaluations that gave numbers."""
        return tuple(evaluation for evaluation in self.evaluations if evaluation.ok)


def contestant(name: str, task: Task, evaluations: Sequence[Evaluation]) -> Contestant:
    """Put the evaluations of one design together."""
    design = evaluations[0].design
    parameters = design.morphology.parameters
    fitness = [e.fitness for e in evaluations if e.ok and e.fitness is not None]
    efficiency = [e.efficiency for e in evaluations if e.ok and e.efficiency is not None]
    return Contestant(
        name=name,
        design=design,
        parameters=dict(zip(task.names, parameters, strict=True)),
        volume=next((e.volume for e in evaluations if e.volume), None) or task.volume(parameters),
        fitness=spread(fitness) if fitness else None,
        efficiency=spread(efficiency) if efficiency else None,
        body=next((e.body for e in evaluations if e.body), {}),
        evaluations=tuple(evaluations),
    )


def finalists(placed: Iterable[tuple[Place, Evaluation]]) -> list[list[Evaluation]]:
    """Return the evaluations of each finalist, one for each training seed."""
    groups: dict[int, list[Evaluation]] = {}
    for place, evaluation in placed:
        if place.stage == "final" and place.changed == "champion":
            groups.setdefault(place.branch, []).append(evaluation)
    return list(groups.values())


def measured_in_final(placed: Iterable[tuple[Place, Evaluation]], role: str) -> list[Evaluation]:
    """Return the final evaluations of `champion` or `human`."""
    return [e for place, e in placed if place.stage == "final" and place.changed == role]
