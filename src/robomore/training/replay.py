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
        ended: (capacity,) bool, no row of the same simulation goes on from this one.
        size: rows filled.
        position: where the next row goes.
    """

    def __init__(
        self, capacity: int, observation_size: int, action_size: int, simulations: int
    ) -> None:
        self.rows = np.empty((capacity, 2 * observation_size + action_size + 2), np.float32)
        self.ended = np.empty(capacity, np.bool_)
        self.size = 0
        self.position = 0
        self._observation_size = observation_size
        self._simulations = simulations

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
        ended = transition.terminated | transition.truncated
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
            self.ended[self.position : self.position + n] = ended
        else:
            places = (self.position + np.arange(n)) % capacity
            self.rows[places] = np.concatenate(parts, axis=1)
            self.ended[places] = ended
        self.position = (self.position + n) % capacity
        self.size = min(self.size + n, capacity)

    def sample(
        self,
        random: np.random.Generator,
        shape: tuple[int, ...],
        discount: float,
        steps: int,
    ) -> NDArray[np.float32]:
        """Return rows (*shape, width) drawn uniformly with replacement, each over some steps.

        A row then starts at one control step and goes on for up to `steps` of the same episode: its
        reward is their discounted sum, its next observation the one after the last of them, and in
        the place of terminated it says what a value there is worth at the start: `discount` to the
        power of the steps, or 0 where the episode terminated.

        Args:
            random: draws.
            shape: of what is drawn.
            discount: what a reward one control step later is worth.
            steps: at least 1, which gives single transitions.
        """
        # Ages count from the oldest row, so that a row and what follows it never wrap around.
        age = random.integers(self.size, size=shape, dtype=np.int32)
        capacity = len(self.rows)
        oldest = self.position if self.size == capacity else 0
        last = (oldest + age) % capacity
        rows = self.rows[last]
        worth = np.full(shape, discount, np.float32)
        goes_on = np.ones(shape, np.bool_)
        for step in range(1, steps):
            age += self._simulations
            goes_on &= ~self.ended[last] & (age < self.size)
            last = np.where(goes_on, (oldest + age) % capacity, last)
            rows[..., -2] += np.where(goes_on, discount**step * self.rows[last, -2], 0)
            worth[goes_on] = discount ** (step + 1)
        if steps > 1:
            tail = self.rows[last]
            then = slice(-2 - self._observation_size, -2)
            rows[..., then], rows[..., -1] = tail[..., then], tail[..., -1]
        rows[..., -1] = worth * (1 - rows[..., -1])
        return rows

    def restore(self, rows: NDArray[np.float32], ended: NDArray[np.bool_], position: int) -> None:
        """Hold `rows`, as they stood in the ring, and go on at `position`."""
        self.size, self.position = len(rows), position
        self.rows[: self.size] = rows
        self.ended[: self.size] = ended
