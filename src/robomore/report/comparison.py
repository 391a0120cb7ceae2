"""Several runs as one page: what each method found, its curves, and the champions in motion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from statistics import fmean
from typing import Any

from markupsafe import Markup

from robomore.errors import InputError
from robomore.report.page import templates, write_page
from robomore.report.plots import BOTTOM, LEFT, RIGHT, TOP, WIDTH
from robomore.report.replays import kept_policies, recorded
from robomore.report.run_groups import Group, run_groups
from robomore.report.scripts import with_scripts
from robomore.report.svg import axes, axis_around, element, figure, tip
from robomore.runs import Run, load_run
from robomore.runs.comparison import Comparison
from robomore.runs.progress import Point, progress
from robomore.runs.words import label, number
from robomore.statistics.spread import FEWEST, Spread, ratio, spread
from robomore.text import sanitize

MOST_MOVING = 8
"""Champions in one picture."""
_HEIGHT = 290.0
_BUDGETS = 40


def write_comparison(folders: Sequence[Path], out: Path) -> Path:
    """Write the page that compares runs; returns its path.

    Args:
        folders: of runs, or one of a study, whose runs are taken.
        out: the file.

    Raises:
        InputError: a folder holds no run, or the file cannot be written.
        RunFolderError: a folder is no run folder.
    """
    paths = {folder: run_folders(folder) for folder in folders}
    if empty := [str(folder) for folder, those in paths.items() if not those]:
        raise InputError(
            f"there is no run in {', '.join(empty)}; name folders of runs, or of a study"
        )
    return write_page(
        render_comparison([load_run(path) for those in paths.values() for path in those]), out
    )


def run_folders(folder: Path) -> list[Path]:
    """Return the folders of the runs of a study, or the folder itself if it is a run's."""
    if (folder / "run.json").exists():
        return [folder]
    return sorted(path.parent for path in folder.glob("cells/*/run.json"))


def render_comparison(runs: Sequence[Run]) -> str:
    """Return the page that compares runs as HTML text."""
    groups = run_groups(runs)
    rows = _rows(groups)
    packs, moving = _episodes(groups)
    units = {run.fitness_unit for run in runs}
    compared = {label(run.objective, run.fitness_unit) for run in runs}
    # One picture has one axis: fitness and efficiency do not share it.
    pictures = dict.fromkeys((group.task, _compared(group)) for group in groups)
    page = (
        templates()
        .get_template("comparison.html")
        .render(
            runs=runs,
            unit=units.pop() if len(units) == 1 else "",
            found=next(iter(compared)) if len(compared) == 1 else "",
            groups=groups,
            rows=rows,
            partly=any(row["counted"] < row["runs"] for row in rows),
            lines=Comparison(tuple(runs)).rows(),
            curves=[
                (
                    f"{task}: {what}" if len(compared) > 1 else task,
                    Markup(drawn),
                    [(group, _band(group)) for group in those],
                )
                for task, what in pictures
                if (those := [g for g in groups if (g.task, _compared(g)) == (task, what)])
                and (drawn := _curves(those))
            ],
            stage=moving,
        )
    )
    return with_scripts(sanitize(page), packs)


def _compared(group: Group) -> str:
    return label(group.objective, group.runs[0].fitness_unit)


def _rows(groups: Sequence[Group]) -> list[dict[str, Any]]:
    """Return a row for each method and task: means over its runs, and intervals.

    All numbers are of what the searches found, which need not be the champion of its run.
    """
    return [
        {
            "group": group,
            "runs": len(group.runs),
            "counted": sum(_found(run) is not None for run in group.runs),
            "found": _over(group, _found),
            "ratio": _over(group, _ratio),
            "fitness": _over(group, lambda run: run.found.fitness if run.found else None),
            "volume": _mean([run.found.volume for run in group.runs if run.found]),
            "steps": _mean([float(run.search_steps) for run in group.runs]),
            "seconds": _mean([run.cost.core_seconds for run in group.runs]),
        }
        for group in groups
    ]


def _over(group: Group, get: Callable[[Run], Spread | None]) -> Spread | None:
    means = [one.mean for run in group.runs if (one := get(run)) is not None]
    return spread(means) if means else None


def _found(run: Run) -> Spread | None:
    return run.found.score(run.objective) if run.found else None


def _ratio(run: Run) -> Spread | None:
    reference = run.reference.score(run.objective) if run.reference else None
    found = _found(run)
    return ratio(found.values, reference.values) if found and reference else None


def _mean(values: Sequence[float]) -> float | None:
    return fmean(values) if values else None


def _curves(groups: Sequence[Group]) -> str:
    """Return the best so far over the search's training: means with their bands (`_band`)."""
    lines = [(group, line) for group in groups if (line := _line(group))]
    if not lines:
        return ""
    every = [
        value for _, line in lines for _, low, mean, high in line for value in (low, mean, high)
    ]
    positive = all(value > 0 for value in every)
    ends = [steps for _, line in lines for steps, *_ in line]
    x = axis_around([0.0, *ends], LEFT, WIDTH - RIGHT)
    y = axis_around(every if positive else [*every, 0.0], _HEIGHT - BOTTOM, TOP, log=positive)
    parts = [
        axes(
            x,
            y,
            "control steps of training in the search",
            _compared(groups[0]),
        )
    ]
    for group, line in lines:
        upper = "L".join(f"{x.at(s):.1f} {y.at(high):.1f}" for s, _, _, high in line)
        lower = "L".join(f"{x.at(s):.1f} {y.at(low):.1f}" for s, low, _, _ in reversed(line))
        middle = "L".join(f"{x.at(s):.1f} {y.at(mean):.1f}" for s, _, mean, _ in line)
        parts.append(element("path", d=f"M{upper}L{lower}Z", klass=f"band {group.kind}"))
        said = f"{group.name}: {number(line[-1][2])} after {line[-1][0]:,.0f} steps"
        said += f", mean of {_share(len(_searches(group)), len(group.runs))}; band: {_band(group)}"
        parts.append(tip(said, element("path", d=f"M{middle}", klass=f"curve {group.kind}")))
    return figure(WIDTH, _HEIGHT, "Best so far of each method", parts)


def _line(group: Group) -> list[tuple[float, float, float, float]]:
    """Return (steps, low, mean, high) from where all runs of a method have a first result."""
    found = _searches(group)
    if not found:
        return []
    begin = max(points[0].steps for points in found)
    end = max(points[-1].steps for points in found)
    line = []
    for i in range(_BUDGETS):
        steps = begin + (end - begin) * i / (_BUDGETS - 1)
        best = [[p.best for p in points if p.steps <= steps][-1] for points in found]
        low, high = spread(best).interval or (min(best), max(best))
        line.append((float(steps), low, fmean(best), high))
    return line


def _searches(group: Group) -> list[tuple[Point, ...]]:
    """Return how far each search came; of those in which nothing was trained, nothing."""
    return [points for run in group.runs if (points := progress(run))]


def _band(group: Group) -> str:
    """Return what the band around a method's line is."""
    count = len(_searches(group))
    if count >= FEWEST:
        return f"95 % interval of the mean over {_share(count, len(group.runs))}"
    if count > 1:
        return f"least to largest of {_share(count, len(group.runs))}"
    return "none, of one run" if count else "nothing was trained"


def _share(count: int, of: int) -> str:
    return f"{count} runs" if count == of else f"{count} of {of} runs"


def _episodes(groups: Sequence[Group]) -> tuple[dict[str, bytes], list[tuple[str, str]]]:
    """Return packed episodes, and (name of the pack, name): each method's best champion."""
    packs: dict[str, bytes] = {}
    moving: list[tuple[str, str]] = []
    several = len({group.task for group in groups}) > 1
    for group in groups:
        with_champion = [run for run in group.runs if run.champion and run.champion.trained]
        ranked = sorted(with_champion, key=_champion_score, reverse=True)
        for run in ranked[:1] if len(groups) > 1 else ranked:
            if len(moving) == MOST_MOVING or run.champion is None:
                break
            key = run.champion.best(run.objective).key
            name = f"{run.task.title}: {group.name}" if several else group.name
            name += f", seed {run.manifest.seed}"
            if key in set(kept_policies(run)) and (episode := recorded(run, key, name)):
                packs[f"champion-{len(moving)}"] = episode
                moving.append((f"champion-{len(moving)}", name))
    return packs, moving


def _champion_score(run: Run) -> float:
    score = run.champion.score(run.objective) if run.champion else None
    return score.mean if score else float("-inf")
