"""What gradient steps read: rows of the replay memory, taken apart."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np


class Minibatch(NamedTuple):
    """Columns of some rows; each (batch, …)."""

    observation: jax.Array
    action: jax.Array
    next_observation: jax.Array
    reward: jax.Array
    future: jax.Array
    """What a value after the row is worth at its start."""


def take_apart(rows: jax.Array, actions: int) -> Minibatch:
    """Return the columns of `rows` (batch, width) in the order of `Replay`."""
    edges = np.cumsum([observation_size(rows, actions), actions, observation_size(rows, actions)])
    observation, action, next_observation, rest = jnp.split(rows, edges, axis=1)
    return Minibatch(observation, action, next_observation, rest[:, 0], rest[:, 1])


def observation_size(rows: jax.Array, actions: int) -> int:
    """Return how many numbers of an observation there are in `rows` (…, width)."""
    return (rows.shape[-1] - actions - 2) // 2
