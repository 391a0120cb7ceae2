"""A Gaussian process with a Matérn-5/2 kernel and a length scale for each parameter (ARD)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LENGTH_PRIOR = (math.sqrt(2), math.sqrt(3))
"""Mean and deviation of a log length scale, beside half the log of the number of parameters: with
many parameters and few points, likelihood alone calls almost all of them irrelevant (Hvarfner et
al. 2024)."""

NOISE_PRIOR = (-4.0, 1.0)
"""Mean and deviation of the log noise variance, where the values have variance 1."""

_LENGTHS = (math.log(1e-2), math.log(1e2))
_NOISES = (math.log(1e-4), 0.0)
_SIGNALS = (math.log(0.05), math.log(20.0))
"""Ranges of the logarithms of the hyper-parameters."""

_SQRT5 = math.sqrt(5)


@dataclass(frozen=True, slots=True)
class Hyperparameters:
    """What a process is made with.

    Attributes:
        lengths: length scale of each parameter, (size,), in the unit cube.
        signal: variance of the function.
        noise: variance of a measurement.
    """

    lengths: Array
    signal: float
    noise: float


class GaussianProcess:
    """A zero-mean process given values at points.

    Args:
        points: (n, size) in the unit cube.
        values: (n,) of mean 0 and variance 1.
        parameters: see `fitted` for how they are found.
    """

    def __init__(self, points: Array, values: Array, parameters: Hyperparameters) -> None:
        self.parameters = parameters
        self._points = points
        self._values = values
        noise: Array = parameters.noise * np.eye(len(points))
        self._factor = np.linalg.cholesky(self._kernel(points, points) + noise)
        self._weights = _solved(self._factor, values)

    @property
    def log_likelihood(self) -> float:
        """Log marginal likelihood of the values."""
        return float(
            -0.5 * self._values @ self._weights
            - np.log(np.diag(self._factor)).sum()
            - 0.5 * len(self._values) * math.log(2 * math.pi)
        )

    def predict(self, points: Array) -> tuple[Array, Array]:
        """Return mean and standard deviation (m,) of the noiseless function at points (m, size)."""
        cross = self._kernel(points, self._points)
        explained = (cross * _solved(self._factor, cross.T).T).sum(axis=1)
        variance = np.maximum(self.parameters.signal - explained, 1e-12)
        mean: Array = cross @ self._weights
        return mean, np.sqrt(variance)

    def gradient(self) -> Array:
        """Return the derivatives of the log likelihood by the logarithms of the length scales
        (size of them), of the signal and of the noise."""
        lengths, signal = self.parameters.lengths, self.parameters.signal
        inverse = _solved(self._factor, np.eye(len(self._points)))
        inner = np.outer(self._weights, self._weights) - inverse
        squares = (self._points[:, None] - self._points[None]) ** 2 / lengths**2
        scaled = _SQRT5 * np.sqrt(squares.sum(axis=2))
        # dk / d log l_i = 5/3 signal (1 + s) exp(-s) d_i^2 / l_i^2, with s = sqrt(5) r.
        shape = signal * 5 / 3 * (1 + scaled) * np.exp(-scaled)
        by_length = 0.5 * np.einsum("ij,ij,ijk->k", inner, shape, squares)
        by_signal = 0.5 * (inner * self._kernel(self._points, self._points)).sum()
        by_noise = 0.5 * self.parameters.noise * np.trace(inner)
        return np.array([*by_length, by_signal, by_noise])

    def _kernel(self, points: Array, others: Array) -> Array:
        lengths, signal = self.parameters.lengths, self.parameters.signal
        one, other = points / lengths, others / lengths
        square = (one**2).sum(1)[:, None] + (other**2).sum(1)[None, :] - 2 * one @ other.T
        scaled = _SQRT5 * np.sqrt(np.maximum(square, 0))
        kernel: Array = signal * (1 + scaled + scaled**2 / 3) * np.exp(-scaled)
        return kernel


def fitted(points: Array, values: Array) -> GaussianProcess:
    """Return the process with the hyper-parameters that are most likely given the values.

    Args:
        points: (n, size) in the unit cube.
        values: (n,) of mean 0 and variance 1.
    """
    # Imported here, since listing the methods needs no SciPy, which takes long to load.
    from scipy.optimize import minimize

    size = points.shape[1]
    centre = LENGTH_PRIOR[0] + 0.5 * math.log(size)
    start = np.array([*[centre - 1] * size, 0.0, NOISE_PRIOR[0]])

    def process(logs: Array) -> GaussianProcess:
        lengths, signal, noise = np.exp(logs[:-2]), math.exp(logs[-2]), math.exp(logs[-1])
        return GaussianProcess(points, values, Hyperparameters(lengths, signal, noise))

    def loss(logs: Array) -> tuple[float, Array]:
        made = process(logs)
        apart = (logs[:-2] - centre) / LENGTH_PRIOR[1]
        noise = (logs[-1] - NOISE_PRIOR[0]) / NOISE_PRIOR[1]
        prior = -0.5 * (apart @ apart + noise**2)
        slope = np.array([*(-apart / LENGTH_PRIOR[1]), 0.0, -noise / NOISE_PRIOR[1]])
        return -(made.log_likelihood + prior), -(made.gradient() + slope)

    bounds = [_LENGTHS] * size + [_SIGNALS, _NOISES]
    found = minimize(loss, start, jac=True, method="L-BFGS-B", bounds=bounds)
    return process(found.x)


def log_expected_improvement(mean: Array, deviation: Array, best: float) -> Array:
    """Return the logarithm of the expected improvement over `best` (Ament et al. 2023).

    Far from any hope of an improvement, the expected improvement itself is 0 in floating point, and
    cannot tell candidates apart; its logarithm can.

    Args:
        mean: (m,) of each candidate.
        deviation: (m,), positive.
        best: what is to be improved on.
    """
    from scipy.special import erfcx, log_ndtr

    gain = (mean - best) / deviation
    near = gain > -1
    found = np.empty_like(gain)
    z = gain[near]
    density = -0.5 * z**2 - 0.5 * math.log(2 * math.pi)
    found[near] = np.log(np.exp(density) + z * np.exp(log_ndtr(z)))
    # For z < -1: log(phi(z) + z Phi(z)) = log phi(z) + log(1 - |z| Phi(z) / phi(z)).
    z = np.minimum(gain[~near], -1.0)
    density = -0.5 * z**2 - 0.5 * math.log(2 * math.pi)
    share = np.abs(z) * erfcx(-z / math.sqrt(2)) * math.sqrt(math.pi / 2)
    # Beyond z = -1e4 the share is 1 to within rounding, and the series 1 - share = 1/z^2 is exact.
    rest = np.where(z < -1e4, 1 / z**2, np.maximum(1 - share, 1e-300))
    found[~near] = density + np.log(rest)
    return found + np.log(deviation)


def _solved(factor: NDArray[np.floating[Any]], right: Array) -> Array:
    """Return what a matrix with this lower Cholesky factor is solved to."""
    solved: Array = np.linalg.solve(factor.T, np.linalg.solve(factor, right))
    return solved
