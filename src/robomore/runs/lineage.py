"""From which design each one was made, for any method: by the parent that each trial names."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from robomore.identity import same_training
from robomore.types import Evaluation, Place


@dataclass(frozen=True, slots=True)
class Record:
    """An evaluation in the place where the search asked for it.

    Attributes:
        place: where in the run.
        evaluation: what was measured.
    """

    place: Place
    evaluation: Evaluation


def best_of(evaluations: Iterable[Evaluation], objective: str) -> Evaluation | None:
    """Return the best evaluation that succeeded; the first among equals."""
    best: tuple[float, Evaluation] | None = None
    for evaluation in evaluations:
        score = evaluation.score(objective)
        if score is not None and (best is None or score > best[0]):
            best = score, evaluation
    return best[1] if best else None


def ancestry(key: str, records: Sequence[Record]) -> tuple[Record, ...]:
    """Return how one evaluation came about: a first idea, each improvement, and itself.

    Args:
        key: of the evaluation.
        records: of the search, in its order.
    """
    by_key: dict[str, Record] = {}
    for record in records:
        by_key.setdefault(record.evaluation.key, record)
    found: list[Record] = []
    seen: set[str] = set()
    while key in by_key and key not in seen:
        # An untrusted ledger may name itself as its own parent.
        seen.add(key)
        found.append(by_key[key])
        key = by_key[key].place.parent
    return tuple(reversed(found))


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
