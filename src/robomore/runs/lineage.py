"""From which design each one was made, for any method: by the parent that each trial names."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

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
