"""The stochastic policy: a Gaussian squashed by tanh (Haarnoja et al. 2018, Appendix C)."""

from __future__ import annotations

import math
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

LOG_DEVIATION = (-20.0, 2.0)
"""Range that the logarithm of the deviation is held in."""


def sample(heads: jax.Array, noise: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Return actions (batch, actions) in [-1, 1] and the logarithm of their density (batch,).

    Args:
        heads: (batch, 2 * actions), the Gaussian's mean and the logarithm of its deviation.
        noise: (batch, actions), standard normal.
    """
    mean, log_deviation = jnp.split(heads, 2, axis=-1)
    log_deviation = jnp.clip(log_deviation, *LOG_DEVIATION)
    raw = mean + jnp.exp(log_deviation) * noise
    # log(1 - tanh(raw)^2) in a form that neither overflows nor cancels.
    squash = 2 * (math.log(2) - raw - jax.nn.softplus(-2 * raw))
    log_prob = -0.5 * jnp.square(noise) - log_deviation - 0.5 * math.log(2 * math.pi) - squash
    return jnp.tanh(raw), log_prob.sum(axis=-1)


def explore(
    layers: list[tuple[NDArray[np.float32], NDArray[np.float32]]],
    observations: NDArray[np.floating[Any]],
    noise: NDArray[np.float32],
) -> NDArray[np.float32]:
    """Return sampled actions (n, actions) of a folded policy, on NumPy alone.

    For a handful of observations this costs less than handing them to a compiled function.
    """
    hidden = np.asarray(observations, dtype=np.float32)
    for weight, bias in layers[:-1]:
        hidden = hidden @ weight
        hidden += bias
        np.maximum(hidden, 0, out=hidden)
    weight, bias = layers[-1]
    mean, log_deviation = np.split(hidden @ weight + bias, 2, axis=-1)
    deviation = np.exp(np.clip(log_deviation, *LOG_DEVIATION))
    action: NDArray[np.float32] = np.tanh(mean + deviation * noise)
    return action
