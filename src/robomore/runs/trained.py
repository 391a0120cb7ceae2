"""One design and everything that was measured of it with one budget, over its training seeds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import fmean

from robomore.errors import InputError
from robomore.statistics.spread import Spread, ratio, spread
from robomore.store.champion import best_seed
from robomore.tasks import Task
from robomore.types import Design, Evaluation


@dataclass(frozen=True, slots=True)
class TrainedDesign:
    """A design with its evaluations.

    Attributes:
        name: its role, such as `champion` or `reference`.
        design: morphology and reward.
        parameters: of the morphology, by name.
        volume: in m³.
        fitness: over the seeds that trained, in the unit of the task; `None` if none did.
        efficiency: likewise, over m³.
        body: `mass` kg, `density` kg/m³, `rest_height` m, as far as known.
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

    @property
    def behaviour(self) -> dict[str, float]:
        """How the policies moved: each measure's mean over the seeds, units in the names."""
        names = [name for evaluation in self.trained[:1] for name in evaluation.behaviour]
        return {
            name: fmean(e.behaviour[name] for e in self.trained if name in e.behaviour)
            for name in names
        }

    def best(self, objective: str) -> Evaluation:
        """Return the evaluation of the best training seed.

        Raises:
            InputError: none trained.
        """
        if not self.trained:
            first = self.evaluations[0]
            raise InputError(
                f"no training of the {self.name} design succeeded ({first.status}: "
                f"{first.diagnosis}); name an evaluation that did with --evaluation KEY"
            )
        return best_seed(self.trained, objective)

    def score(self, objective: str) -> Spread | None:
        """Return what is compared, over the seeds that trained; `None` if none did."""
        scores = [score for e in self.evaluations if (score := e.score(objective)) is not None]
        return spread(scores) if scores else None


def trained_design(name: str, task: Task, evaluations: Sequence[Evaluation]) -> TrainedDesign:
    """Put the evaluations of one design together.

    Args:
        name: its role.
        task: that it was trained for.
        evaluations: at least one, one for each training seed.
    """
    design = evaluations[0].design
    parameters = design.morphology.parameters
    fitness = [e.fitness for e in evaluations if e.ok and e.fitness is not None]
    efficiency = [e.efficiency for e in evaluations if e.ok and e.efficiency is not None]
    return TrainedDesign(
        name=name,
        design=design,
        parameters=dict(zip(task.names, parameters, strict=True)),
        volume=next((e.volume for e in evaluations if e.volume), None) or task.volume(parameters),
        fitness=spread(fitness) if fitness else None,
        efficiency=spread(efficiency) if efficiency else None,
        body=next((e.body for e in evaluations if e.body), {}),
        evaluations=tuple(evaluations),
    )


def over(above: TrainedDesign | None, below: TrainedDesign | None, objective: str) -> Spread | None:
    """Return the ratio of two designs in an objective; `None` where one of them has no score."""
    first, second = (one.score(objective) if one else None for one in (above, below))
    return ratio(first.values, second.values) if first and second else None
