"""What trainings cost: one that went on from rung to rung counts once."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass

from robomore.identity import same_training
from robomore.types import Evaluation


@dataclass(frozen=True, slots=True)
class Cost:
    """What a run has spent: every training counts once, wherever it was asked for.

    Attributes:
        evaluations: that were asked for.
        steps: control steps of training.
        core_seconds: of training and measuring, after each rung of screening too.
    """

    evaluations: int
    steps: int
    core_seconds: float


def trained_steps(evaluations: Iterable[Evaluation]) -> int:
    """Return the control steps of training that evaluations took; what was continued counts once.

    A training that went on from rung to rung has an evaluation for each, of the same steps. One
    that failed counts in full, as it does for a budget: how far it came is not known.
    """
    longest: dict[object, int] = {}
    for evaluation in evaluations:
        training = same_training(evaluation)
        longest[training] = max(evaluation.job.steps, longest.get(training, 0))
    return sum(longest.values())


def spent_seconds(evaluations: Iterable[Evaluation]) -> dict[str, float]:
    """Return the core-seconds that each evaluation took with the rungs that it went on from.

    Args:
        evaluations: of one run, those after each rung too.

    Returns:
        Core-seconds by the evaluation's key.
    """
    found: dict[str, float] = {}
    spent: defaultdict[object, float] = defaultdict(float)
    for evaluation in sorted(evaluations, key=lambda one: one.job.steps):
        training = same_training(evaluation)
        spent[training] += evaluation.seconds
        found[evaluation.key] = spent[training]
    return found
