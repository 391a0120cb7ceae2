"""Reads the same arrays of many simulations into one, and writes one into them."""

from __future__ import annotations

import numpy as np

from robomore.envs.robots.base import Array

# Through memoryviews, since NumPy's own ways take several times longer on such small arrays.


class Gather:
    """Live arrays of each simulation, side by side in one row of `values`.

    Attributes:
        values: (num_envs, width), overwritten by each reading.
        width: numbers of one simulation.
    """

    def __init__(self, views: list[list[Array]]) -> None:
        """Prepare to read `views`: for each simulation, flat arrays of the same sizes."""
        self._rows = [[view.data for view in row] for row in views]
        self._views = [view for row in self._rows for view in row]
        self.width = sum(view.size for view in views[0])
        self.values = np.zeros((len(views), self.width))
        self._flat = self.values.reshape(-1)
        self._bytes = self._flat.data.cast("B")
        size = self.width * self.values.itemsize
        self._of_row = [slice(i * size, (i + 1) * size) for i in range(len(views))]

    def read(self) -> None:
        """Read all simulations."""
        self._bytes[:] = b"".join(self._views)

    def read_one(self, index: int) -> None:
        """Read simulation `index`."""
        self._bytes[self._of_row[index]] = b"".join(self._rows[index])

    def square_sum(self) -> float:
        """Return the sum of the squares of all values: one cheap look at whether they are sane."""
        return float(self._flat.dot(self._flat))


class Scatter:
    """One row of numbers for each simulation, written into its live array."""

    def __init__(self, views: list[Array]) -> None:
        """Prepare to write into `views`, flat arrays of the same size."""
        self._views = [view.data for view in views]
        size = views[0].size
        self._of_row = [slice(i * size, (i + 1) * size) for i in range(len(views))]

    def write(self, values: Array) -> None:
        """Write `values` (num_envs, size), in C order."""
        flat = values.reshape(-1).data
        for view, row in zip(self._views, self._of_row, strict=True):
            view[:] = flat[row]
