"""The best so far over the training that a search has spent, for any method."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from robomore.runs.lineage import Record, same_training

if TYPE_CHECKING:
    from robomore.runs.run import Run


@dataclass(frozen=True, slots=True)
class Point:
    """An evaluation of the search that was trained to the end.

    Attributes:
        record: the evaluation in its place.
        steps: control steps of training that the search had spent when it was done.
        score: of the evaluation.
        best: the best score up to here.
    """

    record: Record
    steps: int
    score: float
    best: float


def progress(run: Run) -> tuple[Point, ...]:
    """Return what a search measured, in its order; what failed or was cut only costs steps."""
    whole = {id(record) for record in run.searched}
    points: list[Point] = []
    trained: dict[object, int] = {}
    spent = 0
    for record in run.records:
        evaluation = record.evaluation
        if run.plan.stage(record.place.stage).role == "final":
            continue
        before = trained.get(same_training(evaluation), 0)
        trained[same_training(evaluation)] = max(before, evaluation.steps)
        spent += max(0, evaluation.steps - before)
        score = evaluation.score(run.objective)
        if id(record) in whole and score is not None:
            best = max(score, points[-1].best) if points else score
            points.append(Point(record, spent, score, best))
    return tuple(points)
