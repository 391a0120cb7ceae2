"""Compiling once what every candidate of a run would compile again.

What a trainer compiles depends on its settings and on the sizes of observation and action, never
on a design. So a process that runs no stranger's code trains for one round on nothing, with JAX's
compilation cache switched on; the candidates' processes then read that cache and may not write to
it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from robomore.training.settings import make_trainer, settings_from
from robomore.training.trainer import Transition
from robomore.types import TrainerSettings


@dataclass(frozen=True, slots=True)
class Shape:
    """What decides a trainer's compiled code."""

    trainer: TrainerSettings
    observation_size: int
    action_size: int


def warm(payload: bytes, scratch: Path, report: Callable[[int], None]) -> bytes:
    """Fill the cache for an encoded `Shape`; runs in a contained child whose `scratch` it is."""
    shape = msgspec.json.decode(payload, type=Shape)
    settings = settings_from(shape.trainer)
    environment = _Nothing(settings.simulations, shape.observation_size, shape.action_size)
    # One round of learning: the first that begins at or after the end of the warm-up.
    rounds = -(-settings.warm_up_steps // settings.steps_per_round) or 1
    make_trainer(shape.trainer).train(environment, rounds * settings.steps_per_round, seed=0)
    return b""


class _Nothing:
    """A `VectorEnvironment` in which nothing happens."""

    def __init__(self, n: int, observation_size: int, action_size: int) -> None:
        self.n = n
        self.observation_size = observation_size
        self.action_size = action_size

    def reset(self, seed: int) -> NDArray[np.float64]:
        return np.zeros((self.n, self.observation_size))

    def step(self, actions: NDArray[np.floating[Any]]) -> Transition:
        observation = self.reset(0)
        no = np.zeros(self.n, np.bool_)
        return Transition(observation, np.zeros(self.n), no, no, observation)

    def state(self) -> dict[str, NDArray[Any]]:
        return {}

    def restore(self, state: dict[str, NDArray[Any]]) -> None:
        """Nothing to restore."""
