"""Settings and a task for tests of trainers, all of one size so that tests compile once."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robomore.training.settings import CrossQSettings, SACSettings, SB3Settings
from robomore.training.trainer import Transition
from robomore.types import TrainerSettings

SETTINGS = CrossQSettings(
    num_envs=4,
    train_freq=4,
    gradient_steps=8,
    learning_starts=128,
    batch_size=64,
    net_arch=(32, 32),
    n_critics=2,
    gamma=0.9,
    # Next to no entropy in the values, so that they are the rewards' alone.
    init_alpha=1e-4,
    # Small enough to be filled and overwritten.
    buffer_size=1_000,
    policy_ema_fraction=0.1,
)

SAC_SETTINGS = SACSettings(
    num_envs=4,
    train_freq=4,
    gradient_steps=8,
    learning_starts=128,
    batch_size=64,
    net_arch=(32, 32),
    gamma=0.9,
    init_alpha=1e-4,
    buffer_size=1_000,
    # A probe has to be learnt in a few hundred gradient steps.
    learning_rate=3e-3,
    tau=0.05,
    policy_ema_fraction=0.1,
    num_eval_checkpoints=3,
)

SB3_SETTINGS = TrainerSettings(
    "sb3",
    {name: getattr(SAC_SETTINGS, name) for name in (field.name for field in fields(SB3Settings))},
)


class Cart:
    """A point mass on a line that is to stand still at 0: the simplest control task there is."""

    num_envs = 4
    observation_size = 2
    action_size = 1
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

    def reward_sums(self) -> dict[str, tuple[int, float]]:
        return {}
