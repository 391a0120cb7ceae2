"""Values as histograms: a critic says how likely each range of values is (HL-Gauss).

It learns by cross-entropy from the target, smeared by a Gaussian over neighbouring bins (Imani and
White 2018; Farebrother et al. 2024, "Stop Regressing"). However far a value is off, its gradient is
bounded.
"""

from __future__ import annotations

import math

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from robomore.training.reward_scale import SPREAD

RANGE = 5.0
"""Values lie within so many standard deviations; targets beyond are clipped. Rewards have to be
normalised, so that the deviation is `SPREAD`."""

SMEARING = 0.75
"""Standard deviation of the Gaussian, in widths of a bin."""


def expected_value(logits: jax.Array) -> jax.Array:
    """Return the mean (…,) of histograms that `logits` (…, bins) stand for."""
    edges = _edges(logits.shape[-1])
    mean: jax.Array = jax.nn.softmax(logits, axis=-1) @ ((edges[1:] + edges[:-1]) / 2)
    return mean


def cross_entropy(logits: jax.Array, target: jax.Array) -> jax.Array:
    """Return the critics' losses, averaged over the batch and summed over critics.

    Args:
        logits: (n_critics, batch, bins).
        target: (batch,), values.
    """
    probabilities = smeared(target, logits.shape[-1])
    surprise = -(probabilities * jax.nn.log_softmax(logits, axis=-1)).sum(axis=-1)
    return surprise.mean(axis=1).sum()


def smeared(target: jax.Array, bins: int) -> jax.Array:
    """Return histograms (batch, bins) of Gaussians around `target` (batch,)."""
    edges = _edges(bins)
    width = edges[1] - edges[0]
    centre = jnp.clip(target, edges[0] + width / 2, edges[-1] - width / 2)[:, None]
    below = jax.scipy.special.erf((edges - centre) / (math.sqrt(2) * SMEARING * width))
    return (below[:, 1:] - below[:, :-1]) / (below[:, -1:] - below[:, :1])


def _edges(bins: int) -> NDArray[np.float32]:
    return np.linspace(-RANGE * SPREAD, RANGE * SPREAD, bins + 1, dtype=np.float32)
