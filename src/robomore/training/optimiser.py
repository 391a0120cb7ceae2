"""Adam (Kingma and Ba 2015) on any tree of arrays."""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

EPSILON = 1e-8


class Adam(NamedTuple):
    """Running mean and mean square of the gradients, each a tree like the parameters', and the
    number of steps taken."""

    mean: Any
    square: Any
    steps: jax.Array | np.int32


def initial_adam(parameters: Any) -> Adam:
    """Return the state before the first step."""
    zeros = jax.tree.map(np.zeros_like, parameters)
    return Adam(zeros, jax.tree.map(np.zeros_like, parameters), np.int32(0))


def adam_step(
    adam: Adam, parameters: Any, gradients: Any, rate: float, beta1: float, beta2: float
) -> tuple[Any, Adam]:
    """Return `parameters` after one step down `gradients`, and the state after it."""
    steps = adam.steps + 1
    mean = jax.tree.map(lambda m, g: beta1 * m + (1 - beta1) * g, adam.mean, gradients)
    square = jax.tree.map(lambda s, g: beta2 * s + (1 - beta2) * g * g, adam.square, gradients)
    # The bias corrections of both moments are scalars, so they go into the rate and epsilon.
    unbias = jnp.sqrt(1 - beta2**steps)
    step = rate * unbias / (1 - beta1**steps)
    moved = jax.tree.map(
        lambda p, m, s: p - step * m / (jnp.sqrt(s) + EPSILON * unbias), parameters, mean, square
    )
    return moved, Adam(mean, square, steps)
