"""The best so far over the training that a search has spent, for any method."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby
from statistics import fmean
from typing import TYPE_CHECKING

from robomore.identity import same_training
from robomore.runs.lineage import Record
from robomore.types import Design, Evaluation

if TYPE_CHECKING:
    from robomore.runs.run import Run


@dataclass(frozen=True, slots=True)
class Point:
    """An evaluation of the search that was trained to the end.

    Attributes:
        record: the evaluation in its place.
        steps: control steps of training that the search had spent when it was done.
        score: of the evaluation.
        leader: the evaluations of the best design up to here, one for each seed that trained.
        best: its score, as the mean of these seeds. A second seed can take it down.
    """

    record: Record
    steps: int
    score: float
    leader: tuple[Evaluation, ...]
    best: float


def progress(run: Run) -> tuple[Point, ...]:
    """Return what a search measured, in the order in which it did; failures and cuts cost steps.

    A design counts once, by the mean of its seeds so far, as methods take it that train one twice.
    Where pairs are screened, all are trained to the first rung before any goes on to the second.
    """
    whole = {id(record) for record in run.searched}
    points: list[Point] = []
    seeds: dict[object, dict[str, tuple[Evaluation, float]]] = {}
    means: dict[object, float] = {}
    leader: object = None
    trained: dict[object, int] = {}
    spent = 0
    for rung, record in _in_time(run):
        training = same_training(record.evaluation)
        spent += max(0, rung - trained.get(training, 0))
        trained[training] = max(rung, trained.get(training, 0))
        score = record.evaluation.score(run.objective)
        ended = rung == record.evaluation.job.steps
        if ended and id(record) in whole and score is not None:
            design = _content(record.evaluation.design)
            known = seeds.setdefault(design, {})
            known[record.evaluation.key] = record.evaluation, score
            means[design] = fmean(one for _, one in known.values())
            if design == leader:
                leader = max(means, key=lambda one: means[one])
            elif not points or means[design] > means[leader]:
                leader = design
            best = tuple(evaluation for evaluation, _ in seeds[leader].values())
            points.append(Point(record, spent, score, best, means[leader]))
    return tuple(points)


def _content(design: Design) -> object:
    """Return what makes two designs the same: the idea behind them does not."""
    return design.morphology.parameters, design.reward.source


def _in_time(run: Run) -> Iterator[tuple[int, Record]]:
    """Yield the records of the search, once for each number of steps that they were trained to."""
    search = [r for r in run.records if run.plan.stage(r.place.stage).role != "final"]
    search.sort(key=lambda record: run.plan.moment(record.place))
    for _, group in groupby(search, key=lambda record: record.place.stage):
        records = list(group)
        for rung in sorted({record.evaluation.job.steps for record in records}):
            yield from ((rung, one) for one in records if one.evaluation.job.steps >= rung)
