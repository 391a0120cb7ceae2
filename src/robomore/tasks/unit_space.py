"""The unit cube of a task's search ranges: each parameter on its own scale, stretched to [0, 1]."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from robomore.errors import InvalidMorphology
from robomore.tasks.task import Task

Array = NDArray[np.float64]

DECIMALS = 5
"""Decimals of a proposed parameter. Training cannot tell finer differences apart."""


class UnitSpace:
    """Maps parameter values to points of the unit cube and back.

    A parameter with a logarithmic scale is stretched logarithmically. So a step of one size doubles
    such a parameter wherever it starts. Values outside of their search range (a designer's, say)
    count as the nearest ones within it.

    Attributes:
        task: the task within its search ranges and search rules.
        size: number of parameters.
    """

    def __init__(self, task: Task) -> None:
        self._whole = task
        self.task = task = task.searched()
        self.size = len(task.parameters)
        self._low = np.array([parameter.low for parameter in task.parameters])
        self._high = np.array([parameter.high for parameter in task.parameters])
        self._log = np.array([parameter.scale == "log" for parameter in task.parameters])
        self._whole_number = np.array([parameter.whole for parameter in task.parameters])
        self._start = self._stretch(self._low)
        self._width = self._stretch(self._high) - self._start

    def units(self, values: Sequence[Sequence[float]] | Array) -> Array:
        """Return the points (n, size) of the unit cube for parameter values (n, size)."""
        rows = np.asarray(values, dtype=float).reshape(-1, self.size)
        return (self._stretch(np.clip(rows, self._low, self._high)) - self._start) / self._width

    def values(self, units: Array) -> Array:
        """Return the parameter values (n, size) of points, rounded and within the bounds."""
        stretched = self._start + np.clip(units, 0, 1) * self._width
        values = np.where(self._log, np.exp(np.where(self._log, stretched, 0)), stretched)
        rounded = np.where(self._whole_number, np.round(values), np.round(values, DECIMALS))
        return np.clip(rounded, self._low, self._high)

    def valid(self, values: Array) -> NDArray[np.bool_]:
        """Return which rows (n,) of the parameter values (n, size) a sampler may propose."""
        return np.array([self._accepts(row) for row in values.tolist()], dtype=bool)

    def volumes(self, values: Array) -> Array:
        """Return the volumes (n,) in m³ of valid parameter values (n, size)."""
        return np.array([self._whole.volume(row) for row in values.tolist()])

    @cached_property
    def radii(self) -> NDArray[np.bool_]:
        """Which parameters (size,) set a radius: as the task says, or as a small change of each one
        shows."""
        if self.task.radii is not None:
            return np.array([name in self.task.radii for name in self.task.names])
        # Of a robot with all the parts that it can have.
        centre = np.where(self._whole_number, 1.0, 0.5)
        changed = self.values(np.vstack((centre, centre + 0.01 * np.eye(self.size))))
        # Unlike `Task.named`, the shapes take values that break the task's rules.
        named = (dict(zip(self.task.names, row, strict=True)) for row in changed.tolist())
        base, *others = ([shape.radius for shape in self.task.solids(one)] for one in named)
        return np.array([base != other for other in others])

    @cached_property
    def lengths(self) -> NDArray[np.bool_]:
        """Which parameters (size,) are lengths or positions in m, radii not among them."""
        metres = np.array([parameter.unit == "m" for parameter in self.task.parameters])
        found: NDArray[np.bool_] = metres & ~self.radii
        return found

    def _accepts(self, values: Sequence[float]) -> bool:
        try:
            self.task.check(values)
        except InvalidMorphology:
            return False
        return True

    def _stretch(self, values: Array) -> Array:
        return np.where(self._log, np.log(np.where(self._log, values, 1)), values)


def distances(points: Array, others: Array) -> Array:
    """Return the Euclidean distances (n, m) between `points` (n, size) and `others` (m, size)."""
    square = (points**2).sum(1)[:, None] + (others**2).sum(1)[None, :] - 2 * points @ others.T
    root: Array = np.sqrt(np.maximum(square, 0))
    return root
