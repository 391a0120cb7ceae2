"""Reads the same arrays of many simulations into one."""

from __future__ import annotations

import numpy as np

from robomore.tasks.environments.base import Array


class Gather:
    """Live arrays of each simulation, side by side in one row of `values`.

    Attributes:
        values: (n, width), overwritten by each reading.
        width: numbers of one simulation.
    """

    def __init__(self, views: list[list[Array]]) -> None:
        """Prepare to read `views`: for each simulation, flat arrays of the same sizes."""
        self._rows = views
        self._views = [view for row in views for view in row]
        self.width = sum(view.size for view in views[0])
        self.values = np.zeros((len(views), self.width))
        self._flat = self.values.reshape(-1)

    def read(self) -> None:
        """Read all simulations."""
        np.concatenate(self._views, out=self._flat)

    def read_one(self, index: int) -> None:
        """Read simulation `index`."""
        np.concatenate(self._rows[index], out=self.values[index])

    def square_sum(self) -> float:
        """Return the sum of the squares of all values: one cheap look at whether they are sane."""
        return float(self._flat.dot(self._flat))
