"""Replay memory: a ring of transitions, one packed float32 row each."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from robomore.training.trainer import Transition


class Replay:
    """Remembers the last `capacity` transitions.

    A row holds observation, action, next observation, reward and terminated, so that a minibatch
    is one gather. Memory is touched only as it fills.

    Attributes:
        rows: (capacity, width) float32.
        size: rows filled.
        position: where the next row goes.
    """

    def __init__(self, capacity: int, observation_size: int, action_size: int) -> None:
        self.rows = np.empty((capacity, 2 * observation_size + action_size + 2), np.float32)
        self.size = 0
        self.position = 0

    def add(
        self,
        observation: NDArray[np.floating[Any]],
        action: NDArray[np.floating[Any]],
        transition: Transition,
    ) -> None:
        """Remember one control step of n simulations.

        Args:
            observation: (n, observation_size), what was acted on.
            action: (n, action_size).
            transition: what came of it. A truncated episode goes on as far as values are
                concerned, so only `terminated` is kept.
        """
        n, capacity = len(observation), len(self.rows)
        parts = (
            observation,
            action,
            transition.final_observation,
            transition.reward[:, None],
            transition.terminated[:, None],
        )
        if self.position + n <= capacity:
            np.concatenate(
                parts, axis=1, out=self.rows[self.position : self.position + n], casting="same_kind"
            )
        else:
            places = (self.position + np.arange(n)) % capacity
            self.rows[places] = np.concatenate(parts, axis=1)
        self.position = (self.position + n) % capacity
        self.size = min(self.size + n, capacity)

    def sample(self, random: np.random.Generator, shape: tuple[int, ...]) -> NDArray[np.float32]:
        """Return rows (*shape, width) drawn uniformly with replacement."""
        return self.rows[random.integers(self.size, size=shape, dtype=np.int32)]

    def restore(self, rows: NDArray[np.float32], position: int) -> None:
        """Hold `rows`, as they stood in the ring, and go on at `position`."""
        self.size, self.position = len(rows), position
        self.rows[: self.size] = rows
