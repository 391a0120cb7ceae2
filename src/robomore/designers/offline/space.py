"""A task's parameter box, each parameter stretched to [0, 1] in its own scale."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robomore.errors import InvalidMorphology
from robomore.tasks.task import Task

Array = NDArray[np.float64]

DECIMALS = 5
"""Of a proposed parameter: readable, and finer than training can tell apart."""


class UnitSpace:
    """Maps bodies to points of the unit cube and back.

    Distances in this space are what "far apart" means: one step of the same size doubles a radius
    wherever it starts, where the task declares the parameter's scale as logarithmic.
    """

    def __init__(self, task: Task) -> None:
        self.task = task
        self.size = len(task.parameters)
        self._low = np.array([parameter.low for parameter in task.parameters])
        self._high = np.array([parameter.high for parameter in task.parameters])
        self._log = np.array([parameter.scale == "log" for parameter in task.parameters])
        self._start = self._stretch(self._low)
        self._width = self._stretch(self._high) - self._start

    def units(self, bodies: Sequence[Sequence[float]] | Array) -> Array:
        """Return points (n, size) of the unit cube for `bodies` (n, size) in the task's units."""
        values = np.asarray(bodies, dtype=float).reshape(-1, self.size)
        return (self._stretch(np.clip(values, self._low, self._high)) - self._start) / self._width

    def values(self, units: Array) -> Array:
        """Return bodies (n, size) in the task's units, rounded and within bounds."""
        stretched = self._start + np.clip(units, 0, 1) * self._width
        values = np.where(self._log, np.exp(np.where(self._log, stretched, 0)), stretched)
        return np.clip(np.round(values, DECIMALS), self._low, self._high)

    def valid(self, bodies: Array) -> NDArray[np.bool_]:
        """Return which of `bodies` (n, size) the task accepts, as (n,)."""
        return np.array([self._accepts(body) for body in bodies], dtype=bool)

    def volumes(self, bodies: Array) -> Array:
        """Return the volume in m^3 of each of `bodies` (n, size), which must be valid."""
        return np.array([self.task.volume(body) for body in bodies.tolist()])

    def _accepts(self, body: Array) -> bool:
        try:
            self.task.check(body.tolist())
        except InvalidMorphology:
            return False
        return True

    def _stretch(self, values: Array) -> Array:
        return np.where(self._log, np.log(np.where(self._log, values, 1)), values)


def distances(points: Array, others: Array) -> Array:
    """Return Euclidean distances (n, m) between `points` (n, size) and `others` (m, size)."""
    square = (points**2).sum(1)[:, None] + (others**2).sum(1)[None, :] - 2 * points @ others.T
    root: Array = np.sqrt(np.maximum(square, 0))
    return root
