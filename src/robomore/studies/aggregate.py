"""All tasks together: each arm over the mean of a base's runs, with intervals and wins."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from statistics import fmean

from robomore.statistics import (
    interquartile_mean,
    mean_of_all,
    probability_of_improvement,
    stratified_interval,
)
from robomore.statistics.aggregate import Array, Scores
from robomore.statistics.spread import FEWEST
from robomore.studies.study import Draw, Results, SeedScores
from robomore.studies.table import Entry, Table
from robomore.visualize.studies import intervals

Bases = Mapping[str, Sequence[SeedScores]]
"""What scores are divided by the mean of, on each task: the runs of an arm, or of a design."""


def over(scores: Scores, bases: Scores) -> list[list[float]]:
    """Return scores over the mean of each task's base, task by task."""
    return [
        [score / fmean(base) for score in runs] for runs, base in zip(scores, bases, strict=True)
    ]


def interval_over(
    runs: Sequence[Sequence[SeedScores]], bases: Sequence[Sequence[SeedScores]]
) -> tuple[float, float] | None:
    """Return the bootstrap interval of the IQM over a base; `None` with too few runs of either.

    The base was measured in a few runs, too: they are drawn anew like those of the arm. On a task
    on which an arm has trainings that are the base's own, and the same run seeds, the seeds are
    drawn once for both: what such a seed adds to one side it adds to the other.

    Args:
        runs: of the arm, task by task.
        bases: likewise, of what they are divided by.
    """
    scores, divisors = _values(runs), _values(bases)
    if min(map(len, (*scores, *divisors)), default=0) < FEWEST or min(map(min, divisors)) <= 0:
        return None
    together = [_share(mine, theirs) for mine, theirs in zip(runs, bases, strict=True)]
    by_seed = [
        {one.seed: one.values for one in theirs} if shared else {}
        for theirs, shared in zip(bases, together, strict=True)
    ]

    def drawn(rows: Sequence[Array], others: Sequence[Array]) -> float:
        apart = iter(others)
        tops: list[list[float]] = []
        bottoms: list[list[float]] = []
        for mine, values, same in zip(runs, by_seed, rows, strict=True):
            chosen = [mine[int(row)] for row in same]
            tops.append([value for one in chosen for value in one.values])
            theirs = [value for one in chosen for value in values[one.seed]] if values else None
            bottoms.append(theirs or next(apart).tolist())
        return interquartile_mean(over(tops, bottoms))

    return stratified_interval(
        drawn,
        [range(len(mine)) for mine in runs],
        [values for values, shared in zip(divisors, together, strict=True) if not shared],
    )


def aggregate_table(results: Results, name: str, base: str, bases: Bases) -> Table:
    """Return each arm over all tasks: IQM, mean, interval, and how likely it beats the base arm.

    Args:
        results: of the study.
        name: of the table.
        base: the arm, or the design, that scores are divided by.
        bases: its runs on each task; a task without any, or whose mean is not above 0, is left out.
    """
    bases = _usable(bases)
    rows: list[tuple[Entry, ...]] = []
    for arm in results.arms:
        runs = [results.answers(task, arm) for task in bases]
        asked = sum(len(results.runs(task, arm)) for task in bases)
        numbers: tuple[Entry, ...] = (None,) * 4
        if runs and all(runs):
            scores = over(_values(runs), _values(bases.values()))
            interval = interval_over(runs, [*bases.values()]) or (None, None)
            numbers = interquartile_mean(scores), *interval, mean_of_all(scores)
        wins = _wins(results, list(bases), arm, base)
        rows.append((arm, *numbers, wins, f"{sum(map(len, runs))} of {asked}"))
    divided = f"over the mean of {base}"
    note = (
        f"Scores are divided by the mean of the runs of {base} on each task. One lucky run of it "
        "lowers them all, and its own IQM need not be 1. "
        "IQM: the mean of the middle half of all runs. The interval is a stratified bootstrap over "
        "the runs of each task, those that are divided by among them; it takes "
        f"{FEWEST} of each, and none of the latter at or below 0. "
        "A run whose answer did not train is in none of these numbers but P(beats): there it "
        "loses against every run that trained, and ties with another one."
    )
    if all(row[1] is None for row in rows):  # a table of dashes tells nothing
        rows, note = [], "No arm has a result on each of these tasks." if bases else ""
    return Table(
        name,
        f"All tasks together, {divided}: {', '.join(bases) or 'no task has a base above 0'}",
        (
            *("arm", f"IQM ({divided})", "95 % from", "95 % to"),
            *(f"mean ({divided})", f"P(beats {base})", "runs"),
        ),
        tuple(rows),
        note,
    )


def interval_figure(results: Results, bases: Bases, base: str) -> dict[str, Draw]:
    """Return a figure of each arm's IQM over `base`, with its interval if there are runs enough."""
    bases = _usable(bases)
    shown: dict[str, tuple[float, tuple[float, float] | None]] = {}
    for arm in results.arms:
        runs = [results.answers(task, arm) for task in bases]
        if runs and all(runs):
            scores = over(_values(runs), _values(bases.values()))
            shown[arm] = interquartile_mean(scores), interval_over(runs, [*bases.values()])
    if not shown:
        return {}
    return {"iqm": partial(intervals, shown, f"IQM over the mean of {base}", f"mean of {base}")}


def _values(tasks: Iterable[Sequence[SeedScores]]) -> list[list[float]]:
    """Return all numbers, task by task."""
    return [[value for one in runs for value in one.values] for runs in tasks]


def _share(runs: Sequence[SeedScores], base: Sequence[SeedScores]) -> bool:
    """Return whether both have the same run seeds, and trainings that are the same."""
    theirs = {one.seed: one.trainings for one in base}
    return {one.seed for one in runs} == set(theirs) and any(
        one.trainings & theirs[one.seed] for one in runs
    )


def _usable(bases: Bases) -> dict[str, Sequence[SeedScores]]:
    """Return the tasks whose base can be divided by."""
    found = zip(bases, _values(bases.values()), strict=True)
    return {task: bases[task] for task, values in found if values and fmean(values) > 0}


def _wins(results: Results, tasks: Sequence[str], arm: str, base: str) -> float | None:
    """Return how likely a run of an arm beats one of the base; `None` where no two can be set
    side by side.
    """
    if base not in results.arms or arm == base:
        return None
    sides = [[_places(results, task, one, (arm, base)) for task in tasks] for one in (arm, base)]
    mine, theirs = sides
    if not tasks or not all(map(len, (*mine, *theirs))):
        return None
    return probability_of_improvement(mine, theirs)


def _places(results: Results, task: str, arm: str, both: tuple[str, str]) -> list[float]:
    """Return a number for each run by which it stands among those of two arms.

    That of a run whose answer did not train is below all scores.
    """
    lowest = min((score for one in both for score in results.scores(task, one)), default=0.0)
    scores = results.scores(task, arm)
    failed = len(results.runs(task, arm)) - len(scores)
    return [*scores, *[lowest - abs(lowest) - 1] * failed]
