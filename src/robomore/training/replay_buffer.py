"""The replay buffer: a ring of transitions, one packed float32 row each."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from robomore.training.trainer import Transition


class ReplayBuffer:
    """Holds the last `capacity` transitions.

    A row holds observation, action, next observation, reward and terminated, so that a minibatch
    is one gather. Memory is touched only as the buffer fills.

    Attributes:
        rows: (capacity, width) float32.
        ended: (capacity,) bool, the episode ended with this row.
        size: rows filled.
        position: where the next row goes.
    """

    def __init__(
        self, capacity: int, observation_size: int, action_size: int, num_envs: int
    ) -> None:
        self.rows = np.empty((capacity, 2 * observation_size + action_size + 2), np.float32)
        self.ended = np.empty(capacity, np.bool_)
        self.size = 0
        self.position = 0
        self._observation_size = observation_size
        self._num_envs = num_envs

    def add(
        self,
        observation: NDArray[np.floating[Any]],
        action: NDArray[np.floating[Any]],
        transition: Transition,
    ) -> None:
        """Add one control step of all environments.

        Args:
            observation: (num_envs, observation_size), what was acted on.
            action: (num_envs, action_size).
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
        gamma: float,
        n_steps: int,
    ) -> NDArray[np.float32]:
        """Return rows (*shape, width), drawn uniformly with replacement, for n-step returns.

        A row starts at one control step and covers up to `n_steps` of the same episode. Its reward
        is their discounted sum, and its next observation the one after the last of them. Its last
        column, in the place of terminated, is the factor that the value there counts with: `gamma`
        to the power of the steps covered, or 0 where the episode terminated.

        Args:
            random: draws.
            shape: of what is drawn.
            gamma: discount factor for each control step.
            n_steps: at least 1, which gives single transitions.
        """
        # Ages count from the oldest row, so that a row and what follows it never wrap around.
        age = random.integers(self.size, size=shape, dtype=np.int32)
        capacity = len(self.rows)
        oldest = self.position if self.size == capacity else 0
        last = (oldest + age) % capacity
        rows = self.rows[last]
        bootstrap = np.full(shape, gamma, np.float32)
        goes_on = np.ones(shape, np.bool_)
        for step in range(1, n_steps):
            age += self._num_envs
            goes_on &= ~self.ended[last] & (age < self.size)
            last = np.where(goes_on, (oldest + age) % capacity, last)
            rows[..., -2] += np.where(goes_on, gamma**step * self.rows[last, -2], 0)
            bootstrap[goes_on] = gamma ** (step + 1)
        if n_steps > 1:
            tail = self.rows[last]
            then = slice(-2 - self._observation_size, -2)
            rows[..., then], rows[..., -1] = tail[..., then], tail[..., -1]
        rows[..., -1] = bootstrap * (1 - rows[..., -1])
        return rows

    def restore(self, rows: NDArray[np.float32], ended: NDArray[np.bool_], position: int) -> None:
        """Hold `rows`, as they stood in the ring, and go on at `position`."""
        self.size, self.position = len(rows), position
        self.rows[: self.size] = rows
        self.ended[: self.size] = ended
