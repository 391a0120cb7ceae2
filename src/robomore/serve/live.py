"""What the live pages show, as HTML: a list of runs, and one run as it goes on."""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlencode

from markupsafe import Markup

from robomore.monitor.remaining import roughly
from robomore.report.heatmap import heatmap
from robomore.report.page import templates
from robomore.report.plots import best_so_far, fitness_over_volume
from robomore.report.replays import kept_policies
from robomore.runs import Run
from robomore.runs.grid import grids
from robomore.runs.words import duration, in_unit, number
from robomore.serve.folder import Watched, why_not_shown
from robomore.text import sanitize

_MOST_MARKS = 3000
"""Marks of a figure that is sent again and again."""


@dataclass(frozen=True, slots=True)
class Line:
    """One run in words.

    Attributes:
        name: of the run.
        address: of its page.
        state: `running`, `finished`, `stopped`, or why it cannot be read.
        best: the best so far, or the champion, with its unit.
        ratio: over the reference design, once that is measured.
        measured: evaluations that are finished, and how many failed.
        far: how far it is, from 0 to 1; `None` where that cannot be told.
        left: about how long it still takes; empty where that is not known.
    """

    name: str
    address: str
    state: str
    best: str
    ratio: str
    measured: str
    far: float | None
    left: str


def overview(root: Path, watched: Sequence[Watched]) -> str:
    """Return the page of all runs."""
    template = templates().get_template("live/overview.html")
    return sanitize(
        template.render(root=root.name, lines=[_line_or_why_not(one) for one in watched])
    )


def run_page(one: Watched, whole: bool = True) -> str:
    """Return the page of one run, or if not `whole` only how far it is.

    If something in the run cannot be shown, the page says why.
    """
    try:
        return _run_page(one, whole)
    except Exception as error:  # noqa: BLE001  # the folder may come from anybody
        return _run_page(_without_content(one, error), whole)


def _without_content(one: Watched, error: Exception) -> Watched:
    return Watched(one.name, one.path, error=why_not_shown(one.path, error))


def _line_or_why_not(one: Watched) -> Line:
    try:
        return line(one)
    except Exception as error:  # noqa: BLE001  # one run must not hide the others
        return line(_without_content(one, error))


def _run_page(one: Watched, whole: bool) -> str:
    run = one.run
    small = whole and run is not None and len(run.records) <= _MOST_MARKS
    template = templates().get_template("live/run.html")
    return sanitize(
        template.render(
            line=line(one),
            run=run,
            whole=whole,
            error=one.error,
            progress=one.progress,
            running=one.running,
            ago=duration(max(0.0, time.time() - one.progress.time)) if one.progress else "",
            throughput=_throughput(one),
            moving=json.dumps(_moving(one.name, run)) if run and whole else "[]",
            best_so_far=Markup(best_so_far(run)) if run and small else "",
            fitness_over_volume=Markup(fitness_over_volume(run)) if run and small else "",
            grids=[
                (g.stage.name, Markup(heatmap(g, run.objective, run.fitness_unit)))
                for g in grids(run)
                if len(g.cells) <= _MOST_MARKS
            ]
            if run and small
            else [],
            query=urlencode({"name": one.name}),
        )
    )


def line(one: Watched) -> Line:
    """Return a run in words."""
    run, told = one.run, one.progress
    champion = run.champion if run else None
    score = champion.score(run.objective) if run and champion else None
    counts = run.counts if run else {}
    failed = sum(count for status, count in counts.items() if status != "ok")
    # A run that ended tells no rest; one that was killed tells nothing any more.
    left = told.left if told and one.running else None
    return Line(
        name=one.name if one.name != "." else one.path.resolve().name,
        address=f"/run?{urlencode({'name': one.name})}",
        state=_state(one),
        best=in_unit(score.mean, run.objective, run.fitness_unit) if run and score else "",
        ratio=f"{number(run.headline.mean, 3)}\N{MULTIPLICATION SIGN}"
        if run and run.headline
        else "",
        measured=f"{sum(counts.values())}" + (f", {failed} failed" if failed else ""),
        far=told.elapsed / max(1e-9, told.elapsed + left) if told and left is not None else None,
        left=f"about {roughly(left)}" if left else "",
    )


def _state(one: Watched) -> str:
    if one.running:
        return "running"
    if one.error and not one.run:
        return one.error
    return "finished" if one.run and one.run.final else "stopped"


def _throughput(one: Watched) -> str:
    """Return how many evaluations this process has measured an hour."""
    told = one.progress
    if told is None or not told.finished or told.elapsed <= 0:
        return ""
    return f"{3600 * told.finished / told.elapsed:.3g} evaluations an hour"


def _moving(name: str, run: Run) -> list[tuple[str, str]]:
    """Return the addresses and names of what is shown in motion: the best now, and the reference.

    Only policies that were kept can be shown.
    """
    kept = set(kept_policies(run))
    found: dict[str, str] = {}
    for said, one in (("best now", run.champion), ("reference design", run.reference)):
        if one and one.trained and (key := one.best(run.objective).key) in kept:
            found.setdefault(key, "champion" if said == "best now" and run.final else said)
    return [
        (f"/run/replay?{urlencode({'name': name, 'key': key})}", said)
        for key, said in found.items()
    ]
