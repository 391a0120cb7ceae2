"""Designs with several objectives: who is beaten by nobody, and how much the set covers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def nondominated(points: Sequence[Sequence[float]]) -> list[bool]:
    """Return for each point whether no other is at least as good in all and better in one.

    Args:
        points: one row for each design; larger is better in every column.
    """
    rows = np.array([list(point) for point in points], dtype=float)
    return [not bool(((rows >= row).all(axis=1) & (rows > row).any(axis=1)).any()) for row in rows]


def hypervolume(points: Sequence[Sequence[float]]) -> float:
    """Return the volume between the origin and the points, overlaps counted once.

    Args:
        points: one row for each design; larger is better in every column, and what is not above 0
            in all columns covers nothing.
    """
    rows = sorted({tuple(point) for point in points if min(point) > 0}, reverse=True)
    if not rows:
        return 0.0
    if len(rows[0]) == 1:
        return rows[0][0]
    # Slices between neighbouring values of the first column; each has the points above it.
    ends = [*(row[0] for row in rows[1:]), 0.0]
    covered = 0.0
    for count, (row, end) in enumerate(zip(rows, ends, strict=True), 1):
        if row[0] > end:
            covered += (row[0] - end) * hypervolume([other[1:] for other in rows[:count]])
    return covered
