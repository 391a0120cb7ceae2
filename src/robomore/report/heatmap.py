"""A grid of pairs as a heat map: morphologies down, rewards across, log colour."""

from __future__ import annotations

import math

from robomore.report.svg import element, figure, text, tip
from robomore.runs.grid import Cell, Grid
from robomore.runs.scores import scored
from robomore.runs.words import number, unit_of

_ANCHORS = ((38, 30, 74), (49, 94, 140), (41, 150, 130), (145, 196, 76), (252, 226, 92))
"""Dark to bright in even steps of lightness, so that it reads without colour too."""
_LEFT, _TOP, _LEGEND = 36.0, 42.0, 54.0
_CELL_HEIGHT = 26.0


def heatmap(grid: Grid, objective: str, unit: str) -> str:
    """Return the grid; a failed cell is crossed out and says why when it is pointed at or tapped.

    A cell that is chosen opens its design.

    What screening cut short is pale, and what it left out says so.

    Args:
        grid: of a run.
        objective: what is shown.
        unit: of the task's fitness.
    """
    rows, columns = grid.shape
    scores = [c.evaluation.score(objective) for c in grid.cells.values() if c.evaluation]
    positive = [score for score in scores if score is not None and score > 0]
    low, high = (min(positive), max(positive)) if positive else (1.0, 1.0)
    width = max(26.0, min(110.0, 370 / columns))
    parts = [text("morphology", 0, 10, klass="note")]
    for column in range(columns):
        middle = _LEFT + (column + 0.5) * width
        said = f"reward {column + 1}" if width > 60 else str(column + 1)
        if column in grid.reference_rewards:
            said = "reference" if width > 60 else "ref."
            said += " reward" if width > 100 else ""
        parts.append(text(said, middle, _TOP - 8, text_anchor="middle", klass="tick"))
    for row in range(rows):
        middle = _TOP + (row + 0.68) * _CELL_HEIGHT
        parts.append(text(str(row + 1), _LEFT - 8, middle, text_anchor="end", klass="tick"))
        for column in range(columns):
            cell = grid.cells[row, column]
            x, y = _LEFT + column * width, _TOP + row * _CELL_HEIGHT
            name = f"morphology {row + 1} x reward {column + 1}"
            shown = _cell(cell, name, objective, unit, (low, high), (x, y, width))
            parts.append(element("g", shown, klass="cut") if cell.cut else shown)
    bottom = _TOP + rows * _CELL_HEIGHT
    if positive:
        parts.append(_legend(low, high, bottom + 18, unit_of(objective, unit)))
    whole = max(_LEFT + columns * width, 300.0)
    return figure(whole, bottom + _LEGEND, f"{objective} in the stage {grid.stage.name}", parts)


def _cell(
    cell: Cell,
    name: str,
    objective: str,
    unit: str,
    ends: tuple[float, float],
    box: tuple[float, float, float],
) -> str:
    x, y, width = box
    evaluation = cell.evaluation
    if evaluation is None:
        said = f"{name}: {cell.reason or 'not measured yet'}"
        klass = "cell-untried" if cell.reason else "cell-open"
        return tip(said, _box(x, y, width, klass=klass))
    score = evaluation.score(objective)
    if score is None:
        said = f"{name}: {evaluation.status}. {evaluation.diagnosis}"
        cross = f"M{x + 4:g} {y + 4:g}l{width - 8:g} {_CELL_HEIGHT - 8:g}"
        mark = element("path", d=cross, klass="cross")
        if width > 84:
            mark = _label(str(evaluation.status), x, y, width)
        shown = _box(x, y, width, klass="cell-failed")
        return element("g", tip(said, shown + mark, evaluation.key), klass="failed")
    said = (
        f"{name}: {scored(evaluation, objective, unit)} after {evaluation.job.steps:,} "
        f"steps{', cut by screening' if cell.cut else ''}. "
        f"{evaluation.design.morphology.idea} / {evaluation.design.reward.idea}"
    )
    fill, ink = colours(share(score, *ends))
    label = _label(number(score, 3), x, y, width, style=f"fill:{ink}") if width > 44 else ""
    return tip(said, _box(x, y, width, fill=fill) + label, evaluation.key)


def _box(x: float, y: float, width: float, **attributes: object) -> str:
    height = _CELL_HEIGHT - 2
    return element("rect", x=x + 1, y=y + 1, width=width - 2, height=height, rx=3, **attributes)


def _label(said: str, x: float, y: float, width: float, **attributes: object) -> str:
    below = y + _CELL_HEIGHT * 0.68
    return text(said, x + width / 2, below, text_anchor="middle", **attributes)


def share(score: float, low: float, high: float) -> float:
    """Return where a score stands between `low` (0) and `high` (1) in powers; below zero is 0."""
    if score <= 0 or high <= low:
        return float(score >= high > 0)
    return math.log(score / low) / math.log(high / low)


def colours(share: float) -> tuple[str, str]:
    """Return the colour of a cell and of the text in it."""
    at = share * (len(_ANCHORS) - 1)
    index = min(int(at), len(_ANCHORS) - 2)
    mixed = [
        round(a + (b - a) * (at - index))
        for a, b in zip(_ANCHORS[index], _ANCHORS[index + 1], strict=True)
    ]
    bright = 0.299 * mixed[0] + 0.587 * mixed[1] + 0.114 * mixed[2]
    return "#" + "".join(f"{c:02x}" for c in mixed), "#10101c" if bright > 120 else "#ffffff"


def _legend(low: float, high: float, y: float, unit: str) -> str:
    steps, width = 24, 180.0
    boxes = [
        element("rect", x=_LEFT + i * width / steps, y=y, width=width / steps + 0.5, height=8,
                fill=colours(i / (steps - 1))[0])
        for i in range(steps)
    ]  # fmt: skip
    ends = text(number(low, 3), _LEFT, y + 22, klass="tick")
    ends += text(
        f"{number(high, 3)} {unit}", _LEFT + width, y + 22, text_anchor="end", klass="tick"
    )
    return "".join(boxes) + ends
