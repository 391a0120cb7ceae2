"""A small Gaussian process as the surrogate model of evaluations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.special import ndtr

from robomore.tasks.unit_space import distances

Array = NDArray[np.float64]

LENGTH_SCALES = (0.15, 0.25, 0.4, 0.65, 1.0)
"""Length scales that are tried, in units of sqrt(dimension), with which distances grow."""
NOISE_FRACTIONS = (0.02, 0.1, 0.3, 0.6)
"""Noise levels that are tried, as fractions of the variance."""


class GaussianProcess:
    """A Gaussian process with a Matérn-5/2 kernel, one length scale and a constant mean.

    The length scale and the noise are those with the highest likelihood. There is one length scale
    for all parameters, because a search evaluates too few morphologies for one each.

    Args:
        points: points in the unit cube, (n, size).
        values: value at each point, (n,).
        counts: number of measurements that each value averages, (n,).
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
            for noise in NOISE_FRACTIONS:
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
        """Return mean and standard deviation, both (m,), of the noiseless value at `points`."""
        cross = self._signal * _matern(distances(points, self._points) / self._length)
        mean = self._mean + self._scale * cross @ self._weights
        explained = (cross * cho_solve(self._factor, cross.T).T).sum(axis=1)
        deviation = self._scale * np.sqrt(np.maximum(self._signal - explained, 1e-9))
        return mean, deviation


def expected_improvement(mean: Array, deviation: Array, best: float) -> Array:
    """Return the expected excess of a normal variable over `best`, with 0 for no excess."""
    gain = (mean - best) / deviation
    density = np.exp(-0.5 * gain**2) / np.sqrt(2 * np.pi)
    improvement: Array = deviation * (gain * ndtr(gain) + density)
    return improvement


def _matern(distance: Array) -> Array:
    scaled = np.sqrt(5) * distance
    kernel: Array = (1 + scaled + scaled**2 / 3) * np.exp(-scaled)
    return kernel
