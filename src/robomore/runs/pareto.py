"""The designs of a run that no other beats in fitness, volume and energy at once."""

from __future__ import annotations

from collections.abc import Iterable
from statistics import fmean
from typing import TYPE_CHECKING

from robomore.runs.words import number
from robomore.statistics.pareto import hypervolume, nondominated
from robomore.types import Evaluation

if TYPE_CHECKING:
    from robomore.runs.run import Run


def pareto_set(run: Run) -> tuple[Evaluation, ...]:
    """Return the designs of the search that no other beats: more fitness, less volume and less
    energy are better. The one with the most fitness comes first.

    A design that was trained with several seeds counts once, by their mean, and its first
    evaluation stands for it. Most were measured once and chosen among many, so their fitness is
    partly luck.
    """
    return tuple(first for first, _ in _unbeaten(run))


def covered(run: Run) -> float | None:
    """Return the hypervolume of the Pareto set, relative to the reference design in the final.

    A design adds to it if it moves forward with less volume and less energy than the reference: the
    sides of its box are its fitness over the reference's, and the fractions of the reference's
    volume and energy that it saves. So 1 is the fitness of the reference for nothing at all.

    The designs had the search's training and mostly one seed, the reference that of the final,
    which can be longer, and the mean of its seeds. So it compares runs of one preset on one task,
    and tells no gain over the reference.

    Returns:
        `None` before the final, and where the reference got nowhere or has no energy.
    """
    reference = [e for e in run.reference.trained if _known(e)] if run.reference else []
    if not reference:
        return None
    fitness, volume, energy = _means(reference)
    if fitness <= 0 or energy <= 0:
        return None
    return hypervolume(
        [
            (gained / fitness, 1 - needed / volume, 1 - spent / energy)
            for _, (gained, needed, spent) in _unbeaten(run)
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


def _unbeaten(run: Run) -> list[tuple[Evaluation, tuple[float, float, float]]]:
    """Return the Pareto set: of each design the first evaluation, and its means."""
    seeds: dict[object, dict[str, Evaluation]] = {}
    for record in run.searched:
        if _known(record.evaluation):
            design = record.evaluation.design
            content = design.morphology.parameters, design.reward.source
            seeds.setdefault(content, {})[record.evaluation.key] = record.evaluation
    found = [(next(iter(one.values())), _means(one.values())) for one in seeds.values()]
    kept = nondominated([(fitness, -volume, -energy) for _, (fitness, volume, energy) in found])
    best = [one for one, stays in zip(found, kept, strict=True) if stays]
    return sorted(best, key=lambda one: -one[1][0])


def _means(evaluations: Iterable[Evaluation]) -> tuple[float, float, float]:
    """Return the means of fitness, volume and energy over seeds of one design."""
    rows = [(e.fitness or 0.0, e.volume or 0.0, e.energy or 0.0) for e in evaluations]
    fitness, volume, energy = (fmean(column) for column in zip(*rows, strict=True))
    return fitness, volume, energy


def _known(evaluation: Evaluation) -> bool:
    numbers = (evaluation.fitness, evaluation.volume, evaluation.energy)
    return evaluation.ok and None not in numbers
