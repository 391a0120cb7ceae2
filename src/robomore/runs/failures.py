"""Evaluations of a run that failed, put together by their reason."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from robomore.runs.lineage import Record
from robomore.types import Place, Status


@dataclass(frozen=True, slots=True)
class Failure:
    """Evaluations that failed for one reason.

    Attributes:
        status: how they ended.
        diagnosis: of the first of them.
        places: where in the run.
    """

    status: Status
    diagnosis: str
    places: tuple[Place, ...]


def failures_of(records: Sequence[Record]) -> tuple[Failure, ...]:
    """Return what failed, by reason, the most frequent first."""
    groups: dict[tuple[Status, str], list[Place]] = {}
    for record in records:
        e = record.evaluation
        if not e.ok:
            groups.setdefault((e.status, e.diagnosis), []).append(record.place)
    found = [Failure(status, said, tuple(at)) for (status, said), at in groups.items()]
    return tuple(sorted(found, key=lambda failure: -len(failure.places)))
