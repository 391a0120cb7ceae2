"""Several runs as one page: what each method found, its curves, and the champions in motion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean
from typing import Any

from markupsafe import Markup

from robomore.errors import InputError
from robomore.report.page import templates, write_page
from robomore.report.plots import BOTTOM, LEFT, RIGHT, TOP, WIDTH
from robomore.report.replays import kept_policies, recorded
from robomore.report.scripts import with_scripts
from robomore.report.svg import axes, axis_around, element, figure, tip
from robomore.runs import Run, load_run
from robomore.runs.comparison import Comparison
from robomore.runs.progress import progress
from robomore.runs.words import label, number
from robomore.statistics.spread import Spread, ratio, spread
from robomore.text import sanitize

MOST_MOVING = 8
"""Champions in one picture."""
_HEIGHT = 290.0
_BUDGETS = 40
_COLOURS = 6


@dataclass(frozen=True, slots=True)
class Group:
    """The runs of one method on one task.

    Attributes:
        task: title of the task.
        name: of the method, with the designer.
        kind: classes of its colour and dashes.
        runs: with different seeds.
    """

    task: str
    name: str
    kind: str
    runs: tuple[Run, ...]


def write_comparison(folders: Sequence[Path], out: Path) -> Path:
    """Write the page that compares runs; returns its path.

    Args:
        folders: of runs, or one of a study, whose runs are taken.
        out: the file.

    Raises:
        InputError: there is no run, or the file cannot be written.
        RunFolderError: a folder is no run folder.
    """
    found = [load_run(path) for folder in folders for path in run_folders(folder)]
    if not found:
        raise InputError("there is no run to compare; name folders of runs, or of a study")
    return write_page(render_comparison(found), out)


def run_folders(folder: Path) -> list[Path]:
    """Return the folders of the runs of a study, or the folder itself if it is a run's."""
    if (folder / "run.json").exists():
        return [folder]
    return sorted(path.parent for path in folder.glob("cells/*/run.json"))


def render_comparison(runs: Sequence[Run]) -> str:
    """Return the page that compares runs as HTML text."""
    groups = _groups(runs)
    packs, moving = _episodes(groups)
    tasks = list(dict.fromkeys(group.task for group in groups))
    units = {run.fitness_unit for run in runs}
    compared = {label(run.objective, run.fitness_unit) for run in runs}
    page = (
        templates()
        .get_template("comparison.html")
        .render(
            runs=runs,
            unit=units.pop() if len(units) == 1 else "",
            found=compared.pop() if len(compared) == 1 else "",
            groups=groups,
            rows=_rows(groups),
            lines=Comparison(tuple(runs)).rows(),
            curves=[
                (task, Markup(drawn), [g for g in groups if g.task == task])
                for task in tasks
                if (drawn := _curves([g for g in groups if g.task == task]))
            ],
            stage=moving,
        )
    )
    return with_scripts(sanitize(page), packs)


def _groups(runs: Sequence[Run]) -> list[Group]:
    found: dict[tuple[str, str], list[Run]] = {}
    for run in runs:
        manifest = run.manifest
        name = manifest.settings.method.name
        name += f", {manifest.designer}" if manifest.designer else ""
        if run.folder.parent.name == "cells":  # of a study, whose arms are named in its folders
            name = run.folder.name.removeprefix(f"{manifest.task}-").rpartition("-s")[0] or name
        found.setdefault((run.task.title, name), []).append(run)
    names = list(dict.fromkeys(name for _, name in found))
    return [
        Group(task, name, _kind(names.index(name)), tuple(those))
        for (task, name), those in found.items()
    ]


def _kind(number: int) -> str:
    """Return the classes of a method's line: a colour, and dashes where colours come again."""
    return f"term-{number % _COLOURS}" + (" again" if number >= _COLOURS else "")


def _rows(groups: Sequence[Group]) -> list[dict[str, Any]]:
    """Return a row for each method and task: means over its runs, and intervals.

    All numbers are of what the searches found, which need not be the champion of its run.
    """
    return [
        {
            "group": group,
            "runs": len(group.runs),
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
    """Return the best so far over the search's training: means, and bands from least to largest."""
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
    first = groups[0].runs[0]
    parts = [
        axes(
            x,
            y,
            "control steps of training in the search",
            label(first.objective, first.fitness_unit),
        )
    ]
    for group, line in lines:
        upper = "L".join(f"{x.at(s):.1f} {y.at(high):.1f}" for s, _, _, high in line)
        lower = "L".join(f"{x.at(s):.1f} {y.at(low):.1f}" for s, low, _, _ in reversed(line))
        middle = "L".join(f"{x.at(s):.1f} {y.at(mean):.1f}" for s, _, mean, _ in line)
        parts.append(element("path", d=f"M{upper}L{lower}Z", klass=f"band {group.kind}"))
        said = f"{group.name}: {number(line[-1][2])} after {line[-1][0]:,.0f} steps"
        said += f", mean of {len(group.runs)} runs"
        parts.append(tip(said, element("path", d=f"M{middle}", klass=f"curve {group.kind}")))
    return figure(WIDTH, _HEIGHT, "Best so far of each method", parts)


def _line(group: Group) -> list[tuple[float, float, float, float]]:
    """Return (steps, low, mean, high) from where all runs of a method have a first result."""
    found = [points for run in group.runs if (points := progress(run))]
    if not found:
        return []
    begin = max(points[0].steps for points in found)
    end = max(points[-1].steps for points in found)
    line = []
    for i in range(_BUDGETS):
        steps = begin + (end - begin) * i / (_BUDGETS - 1)
        best = [[p.best for p in points if p.steps <= steps][-1] for points in found]
        line.append((float(steps), min(best), fmean(best), max(best)))
    return line


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
