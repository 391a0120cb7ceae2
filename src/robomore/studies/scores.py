"""Tables and curves that most studies share: what each arm found, and on what budget."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from statistics import fmean

from robomore.runs import Run
from robomore.runs.progress import Point, progress
from robomore.runs.trained import TrainedDesign
from robomore.runs.words import label, unit_of
from robomore.statistics import interquartile_mean, stratified_interval
from robomore.statistics.spread import FEWEST
from robomore.studies.remeasured import incumbents
from robomore.studies.study import Draw, Results
from robomore.studies.table import Entry, Table
from robomore.text import listed
from robomore.visualize.studies import curves

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
                    _failed(designs),
                    round(fmean(run.search_steps for run in runs)),
                    fmean(run.cost.core_seconds for run in runs),
                )
            )
        rows.append((task, "(human design)", results.reference(task), *[None] * 11))
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
            "failed final trainings",
            "search steps",
            "core seconds",
        ),
        tuple(rows),
        "Each run's answer is trained anew with other seeds, and stands by the mean of those "
        "trainings that did not fail; a run without any is left out. "
        "IQM: the mean of the middle half of the runs (of three or fewer, of all); its interval is "
        f"a bootstrap over them, and takes {FEWEST}. All arms had the same budget at most; "
        "one that ended early, or whose method needs less, has fewer search steps.",
    )


def _failed(designs: Sequence[TrainedDesign]) -> str:
    """Return how many of the trainings of answers failed."""
    asked = sum(len(one.evaluations) for one in designs)
    return f"{asked - sum(len(one.trained) for one in designs)} of {asked}"


def curve_figures(results: Results) -> dict[str, Draw]:
    """Return a figure for each task: the best so far over the budget, measured again, as means.

    It takes a study with `curves`, whose policies are measured again. Where one of a run could not
    be, the run is left out, and named.
    """
    found: dict[str, Draw] = {}
    for task in results.tasks:
        lines: dict[str, list[tuple[float, float]]] = {}
        names: dict[str, str] = {}
        lost: list[str] = []
        for arm in results.arms:
            runs = results.runs(task, arm)
            whole = [run for run in runs if _measured(results, run)]
            lost += [run.folder.name for run in runs if not _measured(results, run)]
            if whole:
                lines[arm] = _curve(results, whole)
                some = f" ({len(whole)} of {len(runs)} runs)"
                names[arm] = arm + (some if len(whole) < len(runs) else "")
        ends = {arm: fmean(s) for arm in lines if (s := results.scores(task, arm))}
        if lines:
            draw = partial(
                curves,
                {names[arm]: line for arm, line in lines.items()},
                {names[arm]: end for arm, end in ends.items()},
                label(results.objective, results.fitness_unit),
                _left_out(lost),
            )
            found[f"curves-{task}"] = draw
    return found


def _measured(results: Results, run: Run) -> bool:
    """Return whether all that was once the best so far of a run was measured again."""
    points = incumbents(run)
    return bool(points) and all(e.key in results.again for p in points for e in p.leader)


def _left_out(names: Sequence[str]) -> str:
    return f"left out, not measured again: {listed(names)}" if names else ""


def _curve(results: Results, runs: Sequence[Run]) -> list[tuple[float, float]]:
    """Return (control steps, mean best so far) of the runs, from where all of them have one.

    The best so far is what the search took for it, measured again: it may go down.

    Args:
        results: of the study.
        runs: at least one; all that was the best in them was measured again.
    """
    found = [(incumbents(run), progress(run)[-1].steps) for run in runs]
    begin = max(points[0].steps for points, _ in found)
    end = max(last for _, last in found)
    line = []
    for number in range(POINTS):
        steps = begin + (end - begin) * number / (POINTS - 1)
        best = [[p for p in points if p.steps <= steps][-1] for points, _ in found]
        line.append((steps, fmean(_again(results, point) for point in best)))
    return line


def _again(results: Results, point: Point) -> float:
    return fmean(results.again[evaluation.key] for evaluation in point.leader)
