"""A small Gaussian process: what is known of bodies that were measured, and how sure that is."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.special import ndtr

from robomore.designers.offline.space import distances

Array = NDArray[np.float64]

LENGTH_SCALES = (0.15, 0.25, 0.4, 0.65, 1.0)
"""Tried, as multiples of the square root of the dimension: typical distances grow with it."""

NOISE_SHARES = (0.02, 0.1, 0.3, 0.6)
"""Tried: share of the variance that is luck of training and of the reward."""


class GaussianProcess:
    """Matérn-5/2 kernel, one length scale, constant mean; the likeliest of a few settings.

    One length scale, not one per parameter: a search measures tens of bodies with up to 24
    parameters, too few to tell the parameters' importances apart.

    Args:
        points: (n, size) in the unit cube.
        values: (n,).
        counts: (n,) how many measurements each value averages.
    """

    def __init__(self, points: Array, values: Array, counts: Array) -> None:
        self._points = points
        self._mean = float(np.average(values, weights=counts))
        spread = float(np.sqrt(np.average((values - self._mean) ** 2, weights=counts)))
        self._scale = max(spread, 1e-6)
        target = (values - self._mean) / self._scale
        apart = distances(points, points)
        best = -np.inf
        for length in np.sqrt(points.shape[1]) * np.array(LENGTH_SCALES):
            for noise in NOISE_SHARES:
                kernel = (1 - noise) * _matern(apart / length)
                kernel[np.diag_indices_from(kernel)] += noise / counts + 1e-9
                factor = cho_factor(kernel, lower=True)
                weights = cho_solve(factor, target)
                likelihood = -0.5 * target @ weights - np.log(np.diag(factor[0])).sum()
                if likelihood > best:
                    best = likelihood
                    self._length, self._signal = float(length), 1 - noise
                    self._factor, self._weights = factor, weights

    def predict(self, points: Array) -> tuple[Array, Array]:
        """Return mean and standard deviation, each (m,), of the noiseless value at `points`."""
        cross = self._signal * _matern(distances(points, self._points) / self._length)
        mean = self._mean + self._scale * cross @ self._weights
        explained = (cross * cho_solve(self._factor, cross.T).T).sum(axis=1)
        deviation = self._scale * np.sqrt(np.maximum(self._signal - explained, 1e-9))
        return mean, deviation


def expected_improvement(mean: Array, deviation: Array, best: float) -> Array:
    """Return by how much a normal variable is expected to exceed `best`, 0 where it falls short."""
    gain = (mean - best) / deviation
    density = np.exp(-0.5 * gain**2) / np.sqrt(2 * np.pi)
    improvement: Array = deviation * (gain * ndtr(gain) + density)
    return improvement


def _matern(distance: Array) -> Array:
    scaled = np.sqrt(5) * distance
    kernel: Array = (1 + scaled + scaled**2 / 3) * np.exp(-scaled)
    return kernel
