"""Tiny environments whose values are known, all of one size so that tests compile once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robomore.training.settings import CrossQSettings, SACSettings, SB3Settings
from robomore.training.trainer import Transition
from robomore.types import TrainerSettings

SETTINGS = CrossQSettings(
    simulations=4,
    train_freq=16,
    gradient_steps=8,
    learning_starts=128,
    batch_size=64,
    hidden=(32, 32),
    discount=0.9,
    # Next to no entropy in the values, so that they are the rewards' alone.
    init_alpha=1e-4,
    # Small enough to be filled and overwritten.
    buffer_size=1_000,
    policy_ema_fraction=0.1,
    # Values are asked for at actions that the policy alone would not try.
    deterministic_env_fraction=0.0,
)

SAC_SETTINGS = SACSettings(
    simulations=4,
    train_freq=16,
    gradient_steps=8,
    learning_starts=128,
    batch_size=64,
    hidden=(32, 32),
    discount=0.9,
    init_alpha=1e-4,
    buffer_size=1_000,
    # A probe has to be learnt in a few hundred gradient steps.
    rate=3e-3,
    tau=0.05,
    policy_ema_fraction=0.1,
    snapshots=3,
)

SB3_SETTINGS = TrainerSettings(
    "sb3",
    {name: getattr(SAC_SETTINGS, name) for name in (field.name for field in fields(SB3Settings))},
)

Ending = tuple[bool, bool]
"""Terminated, truncated."""


class Probe:
    """Episodes of `length` steps; an observation is how much of the episode is gone and a bit.

    Args:
        reward: of the step's number in its episode (n,), the bit (n,) and the actions (n, 1).
        length: control steps in an episode.
        ending: how episodes end.
    """

    n = 4
    observation_size = 2
    action_size = 1
    # Not asked, as long as the settings have their own.
    discount = 0.5
    deterministic_env_fraction = 0.5

    def __init__(
        self,
        reward: Callable[[NDArray[Any], NDArray[Any], NDArray[Any]], NDArray[Any]],
        length: int = 1,
        ending: Ending = (True, False),
    ) -> None:
        self.reward = reward
        self.length = length
        self.ending = ending

    def reset(self, seed: int) -> NDArray[np.float64]:
        self.random = np.random.default_rng(seed)
        self.elapsed = np.zeros(self.num_envs, np.int64)
        self.bit = self.random.integers(0, 2, self.num_envs)
        return self._observation()

    def step(self, actions: NDArray[np.floating[Any]]) -> Transition:
        reward = np.asarray(self.reward(self.elapsed, self.bit, actions), np.float64)
        self.elapsed = self.elapsed + 1
        final = self._observation()
        ended = self.elapsed >= self.length
        self.elapsed = np.where(ended, 0, self.elapsed)
        self.bit = np.where(ended, self.random.integers(0, 2, self.num_envs), self.bit)
        terminated, truncated = (ended & kind for kind in self.ending)
        return Transition(self._observation(), reward, terminated, truncated, final)

    def state(self) -> dict[str, NDArray[Any]]:
        state = self.random.bit_generator.state["state"]
        numbers = [state["state"] >> 64, state["state"] % 2**64]
        numbers += [state["inc"] >> 64, state["inc"] % 2**64]
        return {
            "random": np.array(numbers, np.uint64),
            "buffered": np.array(
                [self.random.bit_generator.state[k] for k in ("has_uint32", "uinteger")], np.uint64
            ),
            "elapsed": self.elapsed,
            "bit": self.bit,
        }

    def restore(self, state: dict[str, NDArray[Any]]) -> None:
        self.random = np.random.default_rng()
        high, low, inc_high, inc_low = (int(word) for word in state["random"])
        self.random.bit_generator.state = {
            "bit_generator": "PCG64",
            "state": {"state": high << 64 | low, "inc": inc_high << 64 | inc_low},
            "has_uint32": int(state["buffered"][0]),
            "uinteger": int(state["buffered"][1]),
        }
        self.elapsed, self.bit = state["elapsed"], state["bit"]

    def _observation(self) -> NDArray[np.float64]:
        return np.stack([self.elapsed / self.length, self.bit], axis=1).astype(np.float64)


class Cart:
    """A point mass on a line that is to stand still at 0: the simplest control task there is."""

    n = 4
    observation_size = 2
    action_size = 1
    # Not asked, as long as the settings have their own.
    discount = 0.5
    deterministic_env_fraction = 0.5
    length = 50

    def reset(self, seed: int) -> NDArray[np.float64]:
        self.random = np.random.default_rng(seed)
        self.elapsed = 0
        self.place = self.random.uniform(-1, 1, (self.num_envs, 2))
        return self.place

    def step(self, actions: NDArray[np.floating[Any]]) -> Transition:
        position, speed = self.place.T
        speed = speed + 0.2 * actions[:, 0]
        position = position + 0.2 * speed
        self.place = final = np.stack([position, speed], axis=1)
        reward = -np.abs(position) - 0.1 * np.abs(speed)
        self.elapsed += 1
        ended = np.full(self.num_envs, self.elapsed == self.length)
        if ended[0]:
            self.elapsed = 0
            self.place = self.random.uniform(-1, 1, (self.num_envs, 2))
        return Transition(self.place, reward, np.zeros(self.num_envs, np.bool_), ended, final)
