"""The replay buffer: a ring of transitions, one packed float32 row each, and exact rewards."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robomore.training.reward_scale import LARGEST, RewardScale, measure_scale
from robomore.training.trainer import Transition


class ReplayBuffer:
    """Holds the last `capacity` transitions.

    A row holds observation, action, next observation, a place for the reward, and terminated, so
    that a minibatch is one gather. Memory is touched only as the buffer fills.

    Attributes:
        rows: (capacity, width) float32.
        rewards: (capacity,) float64: float32 holds neither 1e-50 nor 1e50.
        ended: (capacity,) bool, the episode ended with this row.
        scale: how rewards are normalised when they are drawn; at first they are not.
        size: rows filled.
        position: where the next row goes.
    """

    def __init__(
        self, capacity: int, observation_size: int, action_size: int, num_envs: int
    ) -> None:
        self.rows = np.empty((capacity, 2 * observation_size + action_size + 2), np.float32)
        self.rewards = np.empty(capacity)
        self.ended = np.empty(capacity, np.bool_)
        self.scale = RewardScale()
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
            observation: (num_envs, at least observation_size), what was acted on. Only its first
                numbers are kept.
            action: (num_envs, action_size).
            transition: what came of it. A truncated episode goes on as far as values are
                concerned, so only `terminated` is kept.
        """
        n, capacity = len(observation), len(self.rows)
        places = (self.position + np.arange(n)) % capacity
        ended = transition.terminated | transition.truncated
        parts = (
            observation[:, : self._observation_size],
            action,
            transition.final_observation[:, : self._observation_size],
            np.zeros((n, 1)),
            transition.terminated[:, None],
        )
        self.rows[places] = np.concatenate(parts, axis=1)
        self.rewards[places] = np.clip(transition.reward, -LARGEST, LARGEST)
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
        is their discounted sum, normalised, and its next observation the one after the last of
        them. Its last column, in the place of terminated, is the factor that the value there counts
        with: `gamma` to the power of the steps covered, or 0 where the episode terminated.

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
        total = self.scale.normalize(self.rewards[last], gamma)
        for step in range(1, n_steps):
            age += self._num_envs
            goes_on &= ~self.ended[last] & (age < self.size)
            last = np.where(goes_on, (oldest + age) % capacity, last)
            reward = self.scale.normalize(self.rewards[last], gamma)
            total += np.where(goes_on, gamma**step * reward, 0)
            bootstrap[goes_on] = gamma ** (step + 1)
        if n_steps > 1:
            tail = self.rows[last]
            then = slice(-2 - self._observation_size, -2)
            rows[..., then], rows[..., -1] = tail[..., then], tail[..., -1]
        terminated = rows[..., -1]
        rows[..., -2] = total + bootstrap * terminated * self.scale.value_of_termination
        rows[..., -1] = bootstrap * (1 - terminated)
        return rows

    def measure_scale(self, gamma: float) -> None:
        """Normalise rewards from now on by all that the buffer holds.

        Args:
            gamma: discount factor for each control step.
        """
        oldest = self.position if self.size == len(self.rows) else 0
        # The latest row is of the last environment; an oldest step may be there in part.
        partial = self.size % self._num_envs

        def in_order(column: NDArray[Any]) -> NDArray[Any]:
            return np.roll(column[: self.size], -oldest)[partial:].reshape(-1, self._num_envs)

        terminated = self.rows[: self.size, -1] > 0
        self.scale = measure_scale(
            in_order(self.rewards), in_order(self.ended), in_order(terminated), gamma
        )

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything that `restore` needs, but for the position."""
        held = slice(self.size)
        return {
            "buffer": self.rows[held],
            "buffer_rewards": self.rewards[held],
            "buffer_ended": self.ended[held],
            "buffer_scale": self.scale.to_array(),
        }

    def restore(self, state: Mapping[str, NDArray[Any]], position: int) -> None:
        """Hold what `state` returned, as it stood in the ring, and go on at `position`."""
        self.size, self.position = len(state["buffer"]), position
        self.rows[: self.size] = state["buffer"]
        self.rewards[: self.size] = state["buffer_rewards"]
        self.ended[: self.size] = state["buffer_ended"]
        self.scale = RewardScale(*state["buffer_scale"].tolist())
