"""A tiny environment without physics, in which a trainer's contract is checked within seconds."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robomore.envs.random_state import generator_state, set_generator_state
from robomore.envs.transition import Transition

RewardOf = Callable[[NDArray[Any], NDArray[Any], NDArray[Any]], NDArray[Any]]
"""Rewards (num_envs,) of the step's number in its episode (num_envs,), the bit (num_envs,) and the
actions (num_envs, 1)."""


def _follow_the_bit(
    elapsed: NDArray[Any], bit: NDArray[Any], actions: NDArray[Any]
) -> NDArray[Any]:
    reward: NDArray[Any] = elapsed - np.square(actions[:, 0] - bit)
    return reward


class ProbeEnv:
    """A `TrainingEnv` of short episodes. Each has a random bit that does not change in it.

    An observation is how much of the episode is gone, from 0 to 1, and the bit.
    """

    num_envs = 4
    observation_size = 2
    action_size = 1

    def __init__(
        self,
        reward: RewardOf = _follow_the_bit,
        length: int = 5,
        ending: tuple[bool, bool] = (True, False),
    ) -> None:
        """Make the environment; `reset` has to come before `step`.

        Args:
            reward: by default more towards an episode's end, and less the further the action is
                from the bit.
            length: control steps in an episode.
            ending: whether episodes end as terminated, and whether as truncated.
        """
        self.reward = reward
        self.length = length
        self.ending = ending
        self.random = np.random.default_rng(0)
        self.elapsed = np.zeros(self.num_envs, np.int64)
        self.bit = np.zeros(self.num_envs, np.int64)
        self._sums = np.zeros(2)  # how many rewards there were, and their sum

    def reset(self, seed: int) -> NDArray[np.float64]:
        """Start all episodes anew; returns observations (num_envs, 2)."""
        self.random = np.random.default_rng(seed)
        self.elapsed = np.zeros(self.num_envs, np.int64)
        self.bit = self.random.integers(0, 2, self.num_envs)
        return self._observation()

    def step(self, actions: NDArray[np.floating[Any]]) -> Transition:
        """Apply `actions` (num_envs, 1) for one control step."""
        reward = np.asarray(self.reward(self.elapsed, self.bit, actions), np.float64)
        self._sums += self.num_envs, reward.sum()
        self.elapsed = self.elapsed + 1
        final = self._observation()
        ended = self.elapsed >= self.length
        self.elapsed = np.where(ended, 0, self.elapsed)
        self.bit = np.where(ended, self.random.integers(0, 2, self.num_envs), self.bit)
        terminated, truncated = (ended & kind for kind in self.ending)
        return Transition(self._observation(), reward, terminated, truncated, final)

    def reward_sums(self) -> dict[str, tuple[int, float]]:
        """Return count and sum of the one reward term, `reward`."""
        return {"reward": (int(self._sums[0]), float(self._sums[1]))}

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything needed to continue bit-exactly, as arrays."""
        return {
            "random": generator_state(self.random),
            "elapsed": self.elapsed,
            "bit": self.bit,
            "sums": self._sums.copy(),
        }

    def restore(self, state: dict[str, NDArray[Any]]) -> None:
        """Continue from what `state` returned."""
        set_generator_state(self.random, state["random"])
        self.elapsed, self.bit = state["elapsed"], state["bit"]
        self._sums = state["sums"].copy()

    def _observation(self) -> NDArray[np.float64]:
        return np.stack([self.elapsed / self.length, self.bit], axis=1).astype(np.float64)
