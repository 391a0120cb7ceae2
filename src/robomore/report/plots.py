"""The search in two figures with axes: the best so far, and fitness over volume."""

from __future__ import annotations

from collections.abc import Callable
from itertools import groupby

from robomore.report.svg import Axis, axes, axis_around, element, figure, text, tip
from robomore.runs import Run
from robomore.runs.lineage import Record
from robomore.runs.progress import progress
from robomore.runs.words import equation, in_unit, label, number, short

WIDTH, HEIGHT = 400.0, 290.0
LEFT, RIGHT, TOP, BOTTOM = 46.0, 12.0, 28.0, 42.0
_NAMES = {"energy": "energy_j"}
_LABEL = 60.0
"""Width of a label on a line, at most."""
_COLOURS = 4
"""Stages with a colour of their own; more of them share these."""


def stage_classes(run: Run) -> dict[str, str]:
    """Return the class of the dots of each stage, the final left out."""
    names = [stage.name for stage in run.plan.stages if stage.role == "search"]
    return {name: f"stage-{index % _COLOURS}" for index, name in enumerate(names)}


def off_the_scale(run: Run) -> bool:
    """Return whether the curve of the best has dots at its lower edge that its log scale lacks."""
    scores = [point.score for point in progress(run)]
    level = run.reference.score(run.objective) if run.reference else None
    return min(scores, default=1.0) <= 0 < max([*scores, level.mean if level else 0.0])


def best_so_far(run: Run) -> str:
    """Return the curve of the best score over the search's training, each evaluation a dot.

    One evaluation alone makes no curve.
    """
    points = progress(run)
    if len(points) < 2:
        return ""
    level = run.reference.score(run.objective) if run.reference else None
    values = [point.score for point in points] + ([level.mean] if level else [])
    x = Axis(0.0, 1.02 * max(run.search_steps, 1), LEFT, WIDTH - RIGHT)
    # On a log scale what moved backwards stands at the bottom; without it one good design flattens
    # all others.
    positive = [value for value in values if value > 0]
    y = axis_around(positive or [*values, 0.0], HEIGHT - BOTTOM, TOP, log=bool(positive))
    parts = [
        axes(
            x, y, "control steps of training in the search", label(run.objective, run.fitness_unit)
        )
    ]
    for name, group in groupby(points, key=lambda point: point.record.place.stage):
        border = x.at([*group][-1].steps)
        if name != points[-1].record.place.stage:
            parts.append(
                element("line", x1=border, x2=border, y1=y.start, y2=y.end, klass="border")
            )
    if level:
        at = y.at(level.mean)
        parts.append(
            element("line", x1=x.start, x2=x.end, y1=at, y2=at, klass="reference-line")
            + text("reference design", x.end, at - 5, text_anchor="end", klass="note")
        )
    classes, unit = stage_classes(run), run.fitness_unit
    path = f"M{x.at(points[0].steps):.1f} {y.at(points[0].best):.1f}"
    for point in points:
        place = point.record.place
        said = f"{run.plan.describe(place)}: {in_unit(point.score, run.objective, unit)}"
        parts.append(
            tip(
                said,
                element(
                    "circle",
                    cx=x.at(point.steps),
                    cy=y.at(point.score),
                    r=3.5,
                    klass=f"dot {classes.get(place.stage, '')}",
                ),
                point.record.evaluation.key,
            )
        )
        path += f"H{x.at(point.steps):.1f}V{y.at(point.best):.1f}"
    parts.append(element("path", d=f"{path}H{x.end:.1f}", klass="curve champion"))
    return figure(WIDTH, HEIGHT, "Best so far over the training that the search spent", parts)


def fitness_over_volume(run: Run) -> str:
    """Return all designs by volume and fitness; efficiency is constant along the thin lines.

    A design that only shrinks moves left along the bottom; one that runs farther moves up.
    """
    shown = [r for r in run.records if r.evaluation.fitness is not None and r.evaluation.volume]
    return _scatter(run, shown, "volume", _equal_efficiency)


def fitness_over_energy(run: Run) -> str:
    """Return all designs by the energy of their motors in an episode and by fitness."""
    shown = [r for r in run.records if r.evaluation.fitness is not None and r.evaluation.energy]
    return _scatter(run, shown, "energy", lambda x, y: [])


def _scatter(
    run: Run, shown: list[Record], across: str, lines: Callable[[Axis, Axis], list[str]]
) -> str:
    """Return designs as dots, those of the Pareto set with a ring; empty without any design."""
    if not shown:
        return ""
    values = [float(getattr(record.evaluation, across)) for record in shown]
    x = axis_around(values, LEFT, WIDTH - RIGHT, log=True)
    fitness = [r.evaluation.fitness or 0.0 for r in shown]
    y = axis_around([*fitness, 0.0], HEIGHT - BOTTOM, TOP)
    unit = run.fitness_unit
    parts = [axes(x, y, label(_NAMES.get(across, across)), label("fitness", unit)), *lines(x, y)]
    best = {evaluation.key for evaluation in run.pareto_set}
    for record, value in zip(shown, values, strict=True):
        evaluation = record.evaluation
        said = (
            f"{run.plan.describe(record.place)}: "
            f"{in_unit(evaluation.efficiency, 'efficiency', unit)} = {equation(evaluation, unit)}"
        )
        if evaluation.energy is not None:
            said += f", {number(evaluation.energy)} J"
        at = x.at(value), y.at(evaluation.fitness or 0.0)
        kind = _class_of(record, run)
        radius = 3.5 if kind.startswith("stage") else 5.5
        mark = element("circle", cx=at[0], cy=at[1], r=radius, klass=f"dot {kind}")
        if evaluation.key in best:
            said += ", in the Pareto set"
            mark += element("circle", cx=at[0], cy=at[1], r=radius + 2.5, klass="ring")
        parts.append(tip(said, mark, evaluation.key))
    return figure(WIDTH, HEIGHT, f"Fitness and {across} of all designs", parts)


def _class_of(record: Record, run: Run) -> str:
    for one, kind in ((run.reference, "reference"), (run.champion, "champion")):
        if run.final and one and any(e.key == record.evaluation.key for e in one.evaluations):
            return kind
    return stage_classes(run).get(record.place.stage, "other")


def _equal_efficiency(x: Axis, y: Axis) -> list[str]:
    """Return lines of equal efficiency, factors of ten apart."""
    corners = [y.high / v for v in (x.low, x.high)]
    if y.high <= 0:
        return []
    parts = []
    level = axis_around([min(corners) / 100, max(corners)], 0, 1, log=True)
    for efficiency in (tick for tick in level.ticks(12) if f"{tick:e}".startswith("1.0")):
        ratio = (x.high / x.low) ** (1 / 60)
        points = [
            (volume, efficiency * volume)
            for volume in (x.low * ratio**i for i in range(61))
            if max(0.0, y.low) <= efficiency * volume <= y.high
        ]
        if len(points) < 3:
            continue
        path = " ".join(f"{x.at(v):.1f},{y.at(f):.1f}" for v, f in points)
        end_x, end_y = x.at(points[-1][0]), y.at(points[-1][1])
        # Beside the axis, where its numbers are, the label stands on the other side of its line.
        aside = end_x - x.start < _LABEL
        at, anchor = (end_x + 4, "start") if aside else (end_x - 4, "end")
        parts.append(
            element("polyline", points=path, klass="equal")
            + text(short(efficiency), at, end_y + 11, text_anchor=anchor, klass="note")
        )
    return parts
