"""What an evaluation asks of a trainer, and what a trainer asks of the environment it trains in."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from robomore.envs.transition import Transition as Transition
from robomore.training.policy import MLPPolicy
from robomore.types import Curve

Progress = Callable[[int], None]
"""Called now and then with the control steps done so far, over all environments."""

PROGRESS_SECONDS = 0.3
"""Shortest time between two such calls."""


class TrainingEnv(Protocol):
    """`num_envs` environments with the same morphology and reward, stepped together.

    `robomore.envs.vector_env.VectorEnv` is the real one.
    """

    num_envs: int
    observation_size: int
    action_size: int

    def reset(self, seed: int) -> NDArray[np.float64]:
        """Start all episodes anew; returns observations (num_envs, observation_size)."""
        ...

    def step(self, actions: NDArray[np.floating[Any]]) -> Transition:
        """Apply `actions` (num_envs, action_size) in [-1, 1] for one control step.

        Raises:
            RewardFailed: the reward raised or was not a finite number.
            UnstableSimulation: the physics diverged.
        """
        ...

    def reward_sums(self) -> dict[str, tuple[int, float]]:
        """Return, for each reward term, how many finite values it had so far, and their sum."""
        ...

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything needed to continue bit-exactly, as arrays."""
        ...

    def restore(self, state: dict[str, NDArray[Any]]) -> None:
        """Continue from what `state` returned."""
        ...


@dataclass(frozen=True, slots=True)
class TrainingResult:
    """What a training gave.

    Attributes:
        policies: the policy at the end of training, and before it some from shortly before, oldest
            first: whoever measures them may choose.
        curve: how the training went; `None` if the trainer does not say.
    """

    policies: tuple[MLPPolicy, ...]
    curve: Curve | None = None


class Trainer(Protocol):
    """Trains a policy for one design, in one thread.

    The same settings, seed and environment give the same result to the last bit, whether trained in
    one go or continued from a checkpoint. `robomore.testing.trainers` checks that.
    """

    def prepare(self, observation_size: int, action_size: int) -> None:
        """Do once what every training on a robot of these sizes would otherwise do by itself.

        A trainer that compiles leaves the result in the cache (`robomore.training.compilation`).
        No reward's code runs here.
        """
        ...

    def train(
        self,
        environment: TrainingEnv,
        steps: int,
        seed: int,
        checkpoint: Path | None = None,
        progress: Progress | None = None,
    ) -> TrainingResult:
        """Train until `steps` control steps (over all environments) are done.

        Args:
            environment: is reset with `seed` unless a checkpoint is continued.
            steps: the budget, counted from the very first step. Nothing else may depend on it: a
                longer training passes through the shorter ones.
            seed: of everything random.
            checkpoint: folder to continue from, if it holds a checkpoint of this training after at
                most `steps`. The new checkpoint is left there. `None` keeps none.
            progress: is told the steps done, some times a second at most, and at the end.

        Raises:
            InputError: too few steps.
            TrainingDiverged: a weight or a loss is no longer a finite number.
        """
        ...
