"""An evaluation in words: first what the search compared, and then what that is made of."""

from __future__ import annotations

from robomore.runs.words import equation, in_unit
from robomore.types import Evaluation


def scored(evaluation: Evaluation, objective: str, fitness: str) -> str:
    """Return `703 m/m³ = 14.9 m / 0.0212 m³`, or `0.45 (transport economy); 14.9 m / …`.

    Args:
        evaluation: that gave numbers.
        objective: what the search compared.
        fitness: unit of the task's fitness.
    """
    return in_unit(evaluation.score(objective), objective, fitness) + made_of(
        evaluation, objective, fitness
    )


def made_of(evaluation: Evaluation, objective: str, fitness: str) -> str:
    """Return what stands behind the score in `scored`."""
    said = equation(evaluation, fitness)
    if objective == "efficiency":
        return f" = {said}"
    return f"; {said} = {in_unit(evaluation.efficiency, 'efficiency', fitness)}"
