"""What an evaluation asks of a trainer, and what a trainer asks of the robots it trains on."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from robomore.envs.transition import Transition as Transition
from robomore.errors import InputError
from robomore.training.policy import MLPPolicy

Progress = Callable[[int], None]
"""Called now and then with the control steps done so far."""

PROGRESS_SECONDS = 0.3
"""Time between two such calls."""


class VectorEnvProtocol(Protocol):
    """`n` simulations of one body under one reward, stepped together."""

    num_envs: int
    observation_size: int
    action_size: int
    discount: float
    """What a reward one control step later is worth, as the task sees it."""
    deterministic_env_fraction: float
    """Share of the simulations that the task wants to act without noise once learning has begun."""

    def reset(self, seed: int) -> NDArray[np.float64]:
        """Start all episodes anew; returns observations (n, observation_size)."""
        ...

    def step(self, actions: NDArray[np.floating[Any]]) -> Transition:
        """Apply `actions` (n, action_size) in [-1, 1] for one control step.

        Raises:
            RewardFailed: the reward raised or was not a finite number.
            UnstableSimulation: the physics diverged.
        """
        ...

    def state(self) -> dict[str, NDArray[Any]]:
        """Everything needed to continue bit-exactly, as arrays."""
        ...

    def restore(self, state: dict[str, NDArray[Any]]) -> None:
        """Continue from what `state` returned."""
        ...


class Trainer(Protocol):
    """Trains one policy on one body under one reward, in one thread.

    The same settings, seed and environment give the same policy to the last bit, whether trained
    in one go or continued from a checkpoint.
    """

    def prepare(self, observation_size: int, action_size: int) -> None:
        """Do once what every training on a robot of these sizes would otherwise do by itself.

        A trainer that compiles leaves the result in the cache (`robomore.training.compilation`).
        No reward's code runs here.
        """
        ...

    def train(
        self,
        environment: VectorEnvProtocol,
        steps: int,
        seed: int,
        checkpoint: Path | None = None,
        progress: Progress | None = None,
    ) -> list[MLPPolicy]:
        """Train until `steps` control steps (over all simulations) are done.

        Args:
            environment: is reset with `seed` unless a checkpoint is continued.
            steps: the budget, counted from the very first step.
            seed: of everything random.
            checkpoint: folder to continue from where it holds one of at most `steps`, and to
                leave the new one in; `None` to keep none.
            progress: told the steps done, some times a second at most.

        Returns:
            The policy at the end of training, and before it some from shortly before, oldest
            first: whoever measures may choose.
        """
        ...


def whole_rounds(settings: Any, environment: VectorEnvProtocol, steps: int) -> int:
    """Return how many rounds of acting and learning fit into `steps` control steps.

    Args:
        settings: of an algorithm that learns every `train_freq` control steps.
        environment: simulations that those are spread over.
        steps: the budget.

    Raises:
        InputError: fewer steps than one round, or a round that the simulations do not divide.
    """
    rounds: int = steps // settings.train_freq
    if rounds < 1 or settings.train_freq % environment.num_envs:
        raise InputError(
            f"{steps} steps with {environment.num_envs} simulations: a round is "
            f"{settings.train_freq} steps, at least one is needed, and the number of "
            "simulations has to divide it"
        )
    return rounds
