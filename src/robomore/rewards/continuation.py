"""Whether training under a reward can be interrupted: what it keeps must survive a checkpoint.

A reward runs for a moment, is saved and restored, and goes on. It must give what it gives without
the interruption, and what it gives from the start a second time. So state that no look at the text
finds is noticed before a training is spent on it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robomore.envs.reward_program import RewardProgram
from robomore.envs.vector_env import VectorEnv
from robomore.errors import InvalidReward, UnstableSimulation
from robomore.identity import derive_seed
from robomore.tasks import Task

NUM_ENVS = 2
BEFORE, AFTER = 14, 14
EPISODE_STEPS = 6
"""Control steps before and after the interruption; episodes are short, so that some end in both."""


def check_continuation(task: Task, parameters: Sequence[float], reward: RewardProgram) -> None:
    """Refuse a reward under which an interrupted training would give other numbers.

    Args:
        task: whose robot moves.
        parameters: of the morphology.
        reward: is executed anew for each simulation.

    Raises:
        RewardFailed: it raises, or it keeps what cannot be saved.
        InvalidReward: it gives other numbers after an interruption, or a second time.
    """
    try:
        _check(task, parameters, reward)
    except UnstableSimulation:
        return  # It is the morphology's fault, and training will say so.


def _check(task: Task, parameters: Sequence[float], reward: RewardProgram) -> None:
    random = np.random.default_rng(derive_seed("continuation", task.id))
    step = float(VectorEnv(task, parameters, 1).environment.dt)

    def simulations() -> VectorEnv:
        return VectorEnv(task, parameters, NUM_ENVS, reward, episode_seconds=EPISODE_STEPS * step)

    first = simulations()
    actions = random.uniform(-1, 1, (BEFORE + AFTER, NUM_ENVS, first.action_size))
    first.reset(1)
    once = _rewards(first, actions[:BEFORE])
    saved = first.state()
    on = _rewards(first, actions[BEFORE:])
    if first.reward_runner is not None:
        first.reward_runner.check()

    second = simulations()
    second.restore(saved)
    continued = _rewards(second, actions[BEFORE:])
    if not (np.array_equal(on, continued) and _equal(first.state(), second.state())):
        raise InvalidReward(
            "gives other numbers after an interruption: it keeps something that cannot be saved; "
            "keep it in attributes of `self`, or in a list or an object at the top level"
        )
    again = simulations()
    again.reset(1)
    twice = _rewards(again, actions[:BEFORE])
    if not (np.array_equal(once, twice) and _equal(saved, again.state())):
        raise InvalidReward(
            "gives other numbers for the same motion when it runs a second time; leave out chance, "
            "time, addresses (`id`, `hash`) and memory that was not set (`np.empty`)"
        )


def _rewards(simulations: VectorEnv, actions: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.array([simulations.step(one).reward for one in actions])


def _equal(one: dict[str, NDArray[Any]], other: dict[str, NDArray[Any]]) -> bool:
    return all(
        np.array_equal(one[name], other[name], equal_nan=one[name].dtype.kind == "f")
        for name in one
    )
