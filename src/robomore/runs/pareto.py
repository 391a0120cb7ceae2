"""The designs of a run that no other beats in fitness, volume and energy at once."""

from __future__ import annotations

from typing import TYPE_CHECKING

from robomore.runs.words import number
from robomore.statistics.pareto import hypervolume, nondominated
from robomore.types import Evaluation

if TYPE_CHECKING:
    from robomore.runs.run import Run


def pareto_set(run: Run) -> tuple[Evaluation, ...]:
    """Return the evaluations of the search that no other beats: more fitness, less volume and less
    energy are better. The one with the most fitness comes first.

    They were measured once each and chosen among many, so their fitness is partly luck.
    """
    found = list(
        {r.evaluation.key: r.evaluation for r in run.searched if _known(r.evaluation)}.values()
    )
    kept = nondominated([_gains(one) for one in found])
    best = [one for one, stays in zip(found, kept, strict=True) if stays]
    return tuple(sorted(best, key=lambda one: -(one.fitness or 0.0)))


def covered(run: Run) -> float | None:
    """Return the hypervolume of the Pareto set, relative to the reference design in the final.

    A design adds to it if it moves forward with less volume and less energy than the reference: the
    sides of its box are its fitness over the reference's, and the fractions of the reference's
    volume and energy that it saves. So 1 is the fitness of the reference for nothing at all.

    Returns:
        `None` before the final, and where the reference got nowhere or has no energy.
    """
    reference = [e for e in run.reference.trained if _known(e)] if run.reference else []
    if not reference:
        return None
    fitness, volume, energy = (
        sum(column) / len(reference)
        for column in zip(*((e.fitness, e.volume, e.energy) for e in reference), strict=True)
    )
    if fitness <= 0 or energy <= 0:
        return None
    return hypervolume(
        [
            (one.fitness / fitness, 1 - one.volume / volume, 1 - one.energy / energy)
            for one in pareto_set(run)
            if one.fitness is not None and one.volume is not None and one.energy is not None
        ]
    )


def in_words(run: Run) -> str:
    """Return how many designs a run's Pareto set has, and what they cover where that says much."""
    designs, covers = len(run.pareto_set), run.hypervolume
    said = f"{designs} design{'' if designs == 1 else 's'}"
    if not designs or covers is None:
        return said
    if covers == 0:
        return (
            f"{said}; none gets forward with both less material and less energy than the reference"
        )
    if designs == 1:
        return said
    return (
        f"{said}, hypervolume {number(covers)}: what they gain at once in fitness, material and "
        "energy, where 1 is the reference's fitness for no material and no energy"
    )


def _known(evaluation: Evaluation) -> bool:
    numbers = (evaluation.fitness, evaluation.volume, evaluation.energy)
    return evaluation.ok and None not in numbers


def _gains(evaluation: Evaluation) -> tuple[float, float, float]:
    return evaluation.fitness or 0.0, -(evaluation.volume or 0.0), -(evaluation.energy or 0.0)
