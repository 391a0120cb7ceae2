"""The coarse grid as a heat map: morphologies down, rewards across, log colour."""

from __future__ import annotations

import math

from robomore.report.summary import Summary
from robomore.report.svg import element, figure, hover, text
from robomore.report.words import EFFICIENCY_UNIT, number
from robomore.types import Evaluation

_ANCHORS = ((38, 30, 74), (49, 94, 140), (41, 150, 130), (145, 196, 76), (252, 226, 92))
"""Dark to bright in even steps of lightness, so that it reads without colour too."""
_LEFT, _TOP, _LEGEND = 36.0, 36.0, 54.0
_CELL_HEIGHT = 26.0


def heatmap(summary: Summary) -> str:
    """Return the grid; a failed cell is crossed out and says why under the pointer.

    What screening cut short is pale, and what it left out says so.
    """
    search = summary.manifest.settings.search
    objective = summary.objective
    grid = {
        (place.morphology, place.reward): evaluation
        for place, evaluation in (*summary.placed, *summary.cut)
        if place.stage == "coarse"
    }
    full = summary.manifest.settings.candidate.steps
    untried = {(p.morphology, p.reward): reason for p, reason in summary.untried.items()}
    if not grid:
        return ""
    scores = [score for e in grid.values() if (score := e.score(objective)) is not None]
    positive = [score for score in scores if score > 0]
    low, high = (min(positive), max(positive)) if positive else (1.0, 1.0)
    cell = max(26.0, min(110.0, 560 / search.rewards))
    parts = [
        text(f"reward {column + 1}" if cell > 60 else str(column + 1),
             _LEFT + (column + 0.5) * cell, _TOP - 8, text_anchor="middle", klass="tick")
        for column in range(search.rewards)
    ]  # fmt: skip
    for row in range(search.morphologies):
        middle = _TOP + (row + 0.68) * _CELL_HEIGHT
        parts.append(text(str(row + 1), _LEFT - 8, middle, text_anchor="end", klass="tick"))
        for column in range(search.rewards):
            evaluation = grid.get((row, column))
            share = _share(evaluation, objective, low, high)
            x, y = _LEFT + column * cell, _TOP + row * _CELL_HEIGHT
            if (row, column) in untried and evaluation is None:
                said = f"not tried: {untried[row, column]}"
                parts.append(element("g", hover(said) + _box(x, y, cell, klass="cell-untried")))
                continue
            shown = _cell(evaluation, objective, share, x, y, cell, (row, column))
            short = evaluation is not None and evaluation.ok and evaluation.job.steps < full
            parts.append(element("g", shown, klass="cut") if short else shown)
    parts.append(text("morphology", 0, _TOP - 24, klass="note"))
    bottom = _TOP + search.morphologies * _CELL_HEIGHT
    width = _LEFT + search.rewards * cell
    if positive:
        parts.append(_legend(low, high, bottom + 18, objective))
    return figure(max(width, 300.0), bottom + _LEGEND, f"{objective} of the coarse grid", parts)


def _cell(
    evaluation: Evaluation | None,
    objective: str,
    share: float | None,
    x: float,
    y: float,
    width: float,
    where: tuple[int, int],
) -> str:
    name = f"morphology {where[0] + 1} x reward {where[1] + 1}"
    if evaluation is None:
        said = f"{name}: not measured yet"
        return element("g", hover(said) + _box(x, y, width, klass="cell-open"))
    score = evaluation.score(objective)
    if score is None:
        said = f"{name}: {evaluation.status}. {evaluation.diagnosis}"
        cross = f"M{x + 4:g} {y + 4:g}l{width - 8:g} {_CELL_HEIGHT - 8:g}"
        mark = element("path", d=cross, klass="cross")
        if width > 84:
            mark = _label(str(evaluation.status), x, y, width)
        box = _box(x, y, width, klass="cell-failed")
        return element("g", hover(said) + box + mark, klass="failed")
    said = (
        f"{name}: {number(evaluation.efficiency)} {EFFICIENCY_UNIT} = "
        f"{number(evaluation.fitness)} m / {number(evaluation.volume)} m³ "
        f"after {evaluation.job.steps:,} steps. "
        f"{evaluation.design.morphology.idea} / {evaluation.design.reward.idea}"
    )
    fill, ink = _colours(share or 0.0)
    label = _label(number(score, 3), x, y, width, style=f"fill:{ink}") if width > 44 else ""
    return element("g", hover(said) + _box(x, y, width, fill=fill) + label)


def _box(x: float, y: float, width: float, **attributes: object) -> str:
    height = _CELL_HEIGHT - 2
    return element("rect", x=x + 1, y=y + 1, width=width - 2, height=height, rx=3, **attributes)


def _label(said: str, x: float, y: float, width: float, **attributes: object) -> str:
    below = y + _CELL_HEIGHT * 0.68
    return text(said, x + width / 2, below, text_anchor="middle", **attributes)


def _share(evaluation: Evaluation | None, objective: str, low: float, high: float) -> float | None:
    """Return where a score stands between `low` (0) and `high` (1) in powers; below zero is 0."""
    score = evaluation.score(objective) if evaluation else None
    if score is None or score <= 0 or high <= low:
        return None if score is None else float(score >= high > 0)
    return math.log(score / low) / math.log(high / low)


def _colours(share: float) -> tuple[str, str]:
    """Return the colour of a cell and of the text in it."""
    at = share * (len(_ANCHORS) - 1)
    index = min(int(at), len(_ANCHORS) - 2)
    mixed = [
        round(a + (b - a) * (at - index))
        for a, b in zip(_ANCHORS[index], _ANCHORS[index + 1], strict=True)
    ]
    bright = 0.299 * mixed[0] + 0.587 * mixed[1] + 0.114 * mixed[2]
    return "#" + "".join(f"{c:02x}" for c in mixed), "#10101c" if bright > 120 else "#ffffff"


def _legend(low: float, high: float, y: float, objective: str) -> str:
    steps, width = 24, 180.0
    boxes = [
        element("rect", x=_LEFT + i * width / steps, y=y, width=width / steps + 0.5, height=8,
                fill=_colours(i / (steps - 1))[0])
        for i in range(steps)
    ]  # fmt: skip
    unit = EFFICIENCY_UNIT if objective == "efficiency" else "m"
    ends = text(number(low, 3), _LEFT, y + 22, klass="tick")
    ends += text(
        f"{number(high, 3)} {unit}", _LEFT + width, y + 22, text_anchor="end", klass="tick"
    )
    return "".join(boxes) + ends
