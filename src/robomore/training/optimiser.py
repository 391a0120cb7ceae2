"""Adam (Kingma and Ba 2015) on one array of parameters."""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

EPSILON = 1e-8


class Adam(NamedTuple):
    """Running mean and mean square of the gradients, and the number of steps taken."""

    mean: jax.Array
    square: jax.Array
    steps: jax.Array


def initial_adam(parameters: Any) -> Adam:
    """Return the state before the first step."""
    state: Any = (np.zeros_like(parameters), np.zeros_like(parameters), np.int32(0))
    return Adam(*state)


def adam_step(
    adam: Adam,
    parameters: jax.Array,
    gradients: jax.Array,
    learning_rate: float,
    decay: tuple[float, float],
) -> tuple[jax.Array, Adam]:
    """Return `parameters` after one step down `gradients`, and the state after it.

    Args:
        adam: state before.
        parameters: of any shape.
        gradients: of the same shape.
        learning_rate: size of a step.
        decay: of the running mean and of the running mean square.
    """
    steps = adam.steps + 1
    mean = decay[0] * adam.mean + (1 - decay[0]) * gradients
    square = decay[1] * adam.square + (1 - decay[1]) * gradients * gradients
    # Both moments start at zero; undoing that is a factor on the learning rate and on epsilon.
    unbias = jnp.sqrt(1 - decay[1] ** steps)
    step = learning_rate * unbias / (1 - decay[0] ** steps)
    moved = parameters - step * mean / (jnp.sqrt(square) + EPSILON * unbias)
    return moved, Adam(mean, square, steps)
