"""The report's figures that have two axes: the best so far, and fitness over volume."""

from __future__ import annotations

from robomore.report.summary import Summary
from robomore.report.svg import Axis, axis_around, element, figure, hover, text
from robomore.report.words import EFFICIENCY_UNIT, number, place_name, short
from robomore.types import Evaluation, Place

_WIDTH, _HEIGHT = 500.0, 330.0
_LEFT, _RIGHT, _TOP, _BOTTOM = 60.0, 16.0, 16.0, 44.0

Placed = tuple[Place, Evaluation]


def best_so_far(summary: Summary) -> str:
    """Return the curve of the best score over the search's evaluations, each of them a dot."""
    objective = summary.objective
    search = [pair for pair in summary.placed if pair[0].stage != "final"]
    scored = [
        (index, score, place)
        for index, (place, evaluation) in enumerate(search, 1)
        if (score := evaluation.score(objective)) is not None
    ]
    if not scored:
        return ""
    human = summary.human
    level = getattr(human, objective) if human else None
    values = [score for _, score, _ in scored] + ([level.mean] if level else [])
    x = Axis(0.5, max(len(search), 2) + 0.5, _LEFT, _WIDTH - _RIGHT)
    # On a log scale what moved backwards stands at the bottom; without it one good design flattens
    # all others.
    positive = [value for value in values if value > 0]
    y = axis_around(positive or [*values, 0.0], _HEIGHT - _BOTTOM, _TOP, log=bool(positive))
    unit = EFFICIENCY_UNIT if objective == "efficiency" else "m"
    parts = [_axes(x, y, "evaluations", f"{objective} in {unit}")]

    coarse = sum(place.stage == "coarse" for place, _ in search)
    if 0 < coarse < len(search):
        border = x.at(coarse + 0.5)
        parts.append(
            element("line", x1=border, x2=border, y1=y.start, y2=y.end, klass="border")
            + text("coarse", border - 6, _TOP + 10, text_anchor="end", klass="note")
            + text("fine", border + 6, _TOP + 10, klass="note")
        )
    if level:
        at = y.at(level.mean)
        parts.append(
            element("line", x1=x.start, x2=x.end, y1=at, y2=at, klass="human-line")
            + text("human design", x.end, at - 5, text_anchor="end", klass="note")
        )
    best, path = None, ""
    for index, score, place in scored:
        if best is None or score > best:
            path += (
                f"M{x.at(index):.1f} {y.at(score):.1f}"
                if best is None
                else (f"H{x.at(index):.1f}V{y.at(score):.1f}")
            )
            best = score
        parts.append(
            element(
                "circle",
                hover(f"{place_name(place)}: {number(score)} {unit}"),
                cx=x.at(index), cy=y.at(score), r=3.5, klass=f"dot {place.stage}",
            )
        )  # fmt: skip
    parts.append(element("path", d=f"{path}H{x.end:.1f}", klass="curve"))
    return figure(_WIDTH, _HEIGHT, "Best so far over the evaluations of the search", parts)


def fitness_over_volume(summary: Summary) -> str:
    """Return all designs by volume and fitness; efficiency is constant along the thin lines.

    A design that only shrinks moves left along the bottom; one that runs farther moves up.
    """
    shown = [
        (place, evaluation)
        for place, evaluation in summary.placed
        if evaluation.ok and evaluation.fitness is not None and evaluation.volume
    ]
    if not shown:
        return ""
    fitness = [e.fitness or 0.0 for _, e in shown]
    volume = [e.volume or 0.0 for _, e in shown]
    x = axis_around(volume, _LEFT, _WIDTH - _RIGHT, log=True)
    y = axis_around([*fitness, 0.0], _HEIGHT - _BOTTOM, _TOP)
    parts = [_axes(x, y, "volume in m³", "fitness in m"), *_equal_efficiency(x, y)]
    for place, evaluation in shown:
        kind = place.changed if place.stage == "final" else place.stage
        said = (
            f"{place_name(place)}: {number(evaluation.efficiency)} {EFFICIENCY_UNIT} = "
            f"{number(evaluation.fitness)} m / {number(evaluation.volume)} m³"
        )
        at = x.at(evaluation.volume or 0.0), y.at(evaluation.fitness or 0.0)
        radius = 5.5 if place.stage == "final" else 3.5
        parts.append(
            element("circle", hover(said), cx=at[0], cy=at[1], r=radius, klass=f"dot {kind}")
        )
    return figure(_WIDTH, _HEIGHT, "Fitness and volume of all designs", parts)


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
        parts.append(
            element("polyline", points=path, klass="equal")
            + text(short(efficiency), end_x - 4, end_y + 11, text_anchor="end", klass="note")
        )
    return parts


def _axes(x: Axis, y: Axis, x_name: str, y_name: str) -> str:
    parts = []
    for value in x.ticks():
        at = x.at(value)
        parts.append(
            element("line", x1=at, x2=at, y1=y.start, y2=y.end, klass="grid")
            + text(short(value), at, y.start + 16, text_anchor="middle", klass="tick")
        )
    for value in y.ticks():
        at = y.at(value)
        parts.append(
            element("line", x1=x.start, x2=x.end, y1=at, y2=at, klass="grid")
            + text(short(value), x.start - 6, at + 4, text_anchor="end", klass="tick")
        )
    middle = (y.start + y.end) / 2
    parts.append(text(x_name, (x.start + x.end) / 2, _HEIGHT - 8, text_anchor="middle"))
    parts.append(
        text(y_name, 14, middle, text_anchor="middle", transform=f"rotate(-90 14 {middle:.0f})")
    )
    return "".join(parts)
