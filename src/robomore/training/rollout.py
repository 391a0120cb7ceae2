"""Episodes of a trained policy: no reward, no exploration, one seed each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from robomore.training.policy import MLPPolicy
from robomore.training.trainer import Transition

Array = NDArray[np.float64]


class Episodes(Protocol):
    """Simulations whose episodes the caller starts (`Simulations(…, auto_reset=False)`)."""

    n: int

    @property
    def root_positions(self) -> Array:
        """(n, 2) x and z of the torso in m."""
        ...

    def reset_one(self, index: int, seed: int) -> Array:
        """Start an episode; returns its observation."""
        ...

    def step(self, actions: NDArray[np.floating[Any]]) -> Transition:
        """Apply actions for one control step."""
        ...


@dataclass(frozen=True, slots=True)
class Rollout:
    """What the episodes gave, one number each, in the order of the seeds.

    Attributes:
        distance: x of the torso at the last step minus x after reset, in m.
        highest: highest torso height, in m, the pose after reset included.
        lowest: lowest torso height, in m.
        length: control steps.
        fell: whether the episode ended because the robot was unhealthy.
        effort: mean of |action| over steps and motors, in [0, 1].
    """

    distance: Array
    highest: Array
    lowest: Array
    length: NDArray[np.int64]
    fell: NDArray[np.bool_]
    effort: Array


def rollout(policy: MLPPolicy, simulations: Episodes, seeds: Sequence[int]) -> Rollout:
    """Run one episode per seed, as many side by side as there are simulations.

    An episode's numbers depend on its seed alone, not on what runs beside it.

    Args:
        policy: acts deterministically.
        simulations: must not reset by themselves.
        seeds: of the resets.

    Raises:
        UnstableSimulation: the physics diverged over and over.
    """
    waves = [
        _wave(policy, simulations, seeds[start : start + simulations.n])
        for start in range(0, len(seeds), simulations.n)
    ]
    columns = zip(*waves, strict=True)
    return Rollout(*(np.concatenate(column) for column in columns))


def _wave(policy: MLPPolicy, simulations: Episodes, seeds: Sequence[int]) -> tuple[Any, ...]:
    # Simulations beyond the seeds repeat the last one; their numbers are dropped.
    padded = [seeds[min(index, len(seeds) - 1)] for index in range(simulations.n)]
    observation = np.stack([simulations.reset_one(i, seed) for i, seed in enumerate(padded)])
    last = simulations.root_positions
    start_x = last[:, 0].copy()
    highest, lowest = last[:, 1].copy(), last[:, 1].copy()
    length = np.zeros(simulations.n, np.int64)
    fell = np.zeros(simulations.n, np.bool_)
    effort = np.zeros(simulations.n)
    running = np.ones(simulations.n, np.bool_)
    while running[: len(seeds)].any():
        # Row by row: a product of matrices rounds differently with another number of rows.
        action = np.stack([policy.act(row[None])[0] for row in observation])
        transition = simulations.step(action)
        position = simulations.root_positions
        last[running] = position[running]
        highest[running] = np.maximum(highest, position[:, 1])[running]
        lowest[running] = np.minimum(lowest, position[:, 1])[running]
        length[running] += 1
        effort[running] += np.abs(action).mean(axis=1)[running]
        fell |= running & transition.terminated
        running &= ~(transition.terminated | transition.truncated)
        observation = transition.observation
    kept = slice(len(seeds))
    numbers = (last[:, 0] - start_x, highest, lowest, length, fell, effort / length)
    return tuple(number[kept] for number in numbers)
