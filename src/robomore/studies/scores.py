"""Tables and curves that most studies share: what each arm found, and on what budget."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from statistics import fmean

from robomore.runs.progress import Point, progress
from robomore.runs.words import label, unit_of
from robomore.statistics import (
    interquartile_mean,
    mean_of_all,
    probability_of_improvement,
    stratified_interval,
)
from robomore.statistics.aggregate import Scores
from robomore.statistics.spread import FEWEST
from robomore.studies.remeasured import incumbents
from robomore.studies.study import Draw, Results
from robomore.studies.table import Entry, Table
from robomore.visualize.studies import curves, intervals

Bases = Mapping[str, Sequence[float]]
"""What scores are divided by the mean of, on each task: the runs of an arm, or of a design."""

POINTS = 60
"""Budgets at which a curve is read."""


def found_table(results: Results) -> Table:
    """Return what each arm found on each task: mean and IQM of its runs, and their range."""
    rows: list[tuple[Entry, ...]] = []
    for task in results.tasks:
        for arm in results.arms:
            scores = results.scores(task, arm)
            runs = results.runs(task, arm)
            designs = [run.found for run in runs if run.found]
            fitness = [one.fitness.mean for one in designs if one.fitness]
            enough = len(scores) >= FEWEST
            rows.append(
                (
                    task,
                    arm,
                    fmean(scores) if scores else None,
                    interquartile_mean([scores]) if scores else None,
                    *(
                        stratified_interval(interquartile_mean, [scores])
                        if enough
                        else (None, None)
                    ),
                    min(scores, default=None),
                    max(scores, default=None),
                    fmean(fitness) if fitness else None,
                    fmean(one.volume for one in designs) if designs else None,
                    f"{len(scores)} of {len(runs)}",
                    round(fmean(run.search_steps for run in runs)),
                    fmean(run.cost.core_seconds for run in runs),
                )
            )
        rows.append((task, "(human design)", results.reference(task), *[None] * 10))
    unit = unit_of(results.objective, results.fitness_unit) or "no unit"
    return Table(
        "found",
        f"What each search found, trained anew: {label(results.objective, results.fitness_unit)}",
        (
            "task",
            "arm",
            f"mean ({unit})",
            f"IQM ({unit})",
            "95 % from",
            "95 % to",
            f"lowest run ({unit})",
            f"highest run ({unit})",
            label("fitness", results.fitness_unit),
            "volume (m³)",
            "runs",
            "search steps",
            "core seconds",
        ),
        tuple(rows),
        "Each run's answer is trained anew with other seeds, and a run without one is left out. "
        "IQM: the mean of the middle half of the runs; its interval is a bootstrap over them, and "
        f"takes {FEWEST}. All arms had the same budget at most; one that ended early, or whose "
        "method needs less, has fewer search steps.",
    )


def over(scores: Scores, bases: Scores) -> list[list[float]]:
    """Return scores over the mean of each task's base, task by task."""
    return [
        [score / fmean(base) for score in runs] for runs, base in zip(scores, bases, strict=True)
    ]


def interval_over(scores: Scores, bases: Scores) -> tuple[float, float] | None:
    """Return the bootstrap interval of the IQM over a base; `None` with too few runs of either.

    The base was measured in a few runs, too: they are drawn anew like those of the arm. An arm over
    its own runs is drawn once.

    Args:
        scores: of the arm, task by task.
        bases: likewise, of what they are divided by.
    """
    if min(map(len, (*scores, *bases)), default=0) < FEWEST or min(map(min, bases)) <= 0:
        return None
    if scores == bases:
        return stratified_interval(lambda runs: interquartile_mean(over(runs, runs)), scores)
    return stratified_interval(
        lambda runs, others: interquartile_mean(over(runs, others)), scores, bases
    )


def _usable(bases: Bases) -> dict[str, Sequence[float]]:
    """Return the tasks whose base can be divided by."""
    return {task: runs for task, runs in bases.items() if runs and fmean(runs) > 0}


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
    against = [results.scores(task, base) for task in bases] if base in results.arms else []
    for arm in results.arms:
        runs = [results.scores(task, arm) for task in bases]
        if not runs or not all(runs):
            rows.append((arm, *[None] * 6))
            continue
        divisors = list(bases.values())
        scores = over(runs, divisors)
        interval = interval_over(runs, divisors) or (None, None)
        wins = None
        if against and all(against) and arm != base:
            wins = probability_of_improvement(runs, against)
        count = sum(map(len, runs))
        rows.append((arm, interquartile_mean(scores), *interval, mean_of_all(scores), wins, count))
    told = any(entry is not None for row in rows for entry in row[1:])
    note = (
        "IQM: the mean of the middle half of all runs. The interval is a stratified bootstrap over "
        f"the runs of each task, those that are divided by among them, and takes {FEWEST} of each."
    )
    if not told:  # a table of dashes tells nothing
        rows, note = [], "No arm has a result on each of these tasks." if bases else ""
    return Table(
        name,
        f"All tasks together, over {base}: {', '.join(bases) or 'no task has a base above 0'}",
        ("arm", "IQM", "95 % from", "95 % to", "mean", f"P(beats {base})", "runs"),
        tuple(rows),
        note,
    )


def curve_figures(results: Results) -> dict[str, Draw]:
    """Return a figure for each task: the best so far over the budget, measured again, as means."""
    found: dict[str, Draw] = {}
    for task in results.tasks:
        lines = {arm: line for arm in results.arms if (line := _curve(results, task, arm))}
        ends = {arm: fmean(s) for arm in lines if (s := results.scores(task, arm))}
        if lines:
            draw = partial(curves, lines, ends, label(results.objective, results.fitness_unit))
            found[f"curves-{task}"] = draw
    return found


def interval_figure(results: Results, bases: Bases, base: str) -> dict[str, Draw]:
    """Return a figure of each arm's IQM over `base`, with its interval if there are runs enough."""
    bases = _usable(bases)
    divisors = list(bases.values())
    shown: dict[str, tuple[float, tuple[float, float] | None]] = {}
    for arm in results.arms:
        runs = [results.scores(task, arm) for task in bases]
        if runs and all(runs):
            interval = interval_over(runs, divisors)
            shown[arm] = (interquartile_mean(over(runs, divisors)), interval)
    if not shown:
        return {}
    return {"iqm": partial(intervals, shown, f"IQM over {base}")}


def _curve(results: Results, task: str, arm: str) -> list[tuple[float, float]]:
    """Return (control steps, mean best so far) of the runs, from where all of them have one.

    The best so far is what the search took for it, measured again: it may go down.
    """
    runs = [
        (points, progress(run)) for run in results.runs(task, arm) if (points := incumbents(run))
    ]
    if not runs:
        return []
    begin = max(points[0].steps for points, _ in runs)
    end = max(whole[-1].steps for _, whole in runs)
    line = []
    for number in range(POINTS):
        steps = begin + (end - begin) * number / (POINTS - 1)
        best = [[p for p in points if p.steps <= steps][-1] for points, _ in runs]
        line.append((steps, fmean(_again(results, point) for point in best)))
    return line


def _again(results: Results, point: Point) -> float:
    # Without a policy, as for a run that trained nothing, there is what the search saw.
    return results.again.get(point.record.evaluation.key, point.score)
