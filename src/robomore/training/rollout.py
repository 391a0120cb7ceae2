"""Measuring a policy: whole episodes, each with its own seed, and no reward anywhere."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from robomore.envs.transition import Transition


class Policy(Protocol):
    """What acts; `robomore.training.policy.MLPPolicy` is one."""

    def act(self, observations: NDArray[np.floating[Any]]) -> NDArray[np.float32]: ...


class EvaluationEnv(Protocol):
    """Environments whose episodes are started one by one (`VectorEnv` without `auto_reset`)."""

    @property
    def num_envs(self) -> int: ...

    @property
    def root_positions(self) -> NDArray[np.float64]:
        """(num_envs, 2) x and z of the torso in m, at the end of an episode too."""
        ...

    def reset_one(self, index: int, seed: int) -> NDArray[np.float64]: ...

    def step(self, actions: NDArray[np.floating[Any]]) -> Transition: ...


@dataclass(frozen=True)
class Rollout:
    """What each episode gave, in the order of the seeds; every array is (episodes,).

    Attributes:
        lowest: lowest torso height, in m.
        rest_height: torso height at the start, in m.
        length: control steps that the episode lasted.
        fell: whether it ended because the robot was unhealthy.
        effort: mean size of an action's components, of at most 1.
        jerk: mean change of an action's components from step to step, of at most 2.
    """

    lowest: NDArray[np.float64]
    rest_height: NDArray[np.float64]
    length: NDArray[np.int64]
    fell: NDArray[np.bool_]
    effort: NDArray[np.float64]
    jerk: NDArray[np.float64]


def rollout(policy: Policy, environment: EvaluationEnv, seeds: Sequence[int]) -> Rollout:
    """Run one episode of the deterministic policy for each of `seeds`.

    Args:
        policy: what acts.
        environment: has no reward, and does not start episodes by itself.
        seeds: one for each episode, at least one.

    Raises:
        UnstableSimulation: the physics diverged over and over.
    """
    waiting = list(enumerate(seeds))[::-1]
    running: dict[int, _Episode] = {}
    finished: list[_Episode] = []

    def begin(i: int) -> NDArray[np.float64]:
        # An environment without work goes on idly, so that batches keep their size.
        number, seed = waiting.pop() if waiting else (None, seeds[-1])
        first = environment.reset_one(i, seed)
        if number is not None:
            running[i] = _Episode(number, rest_height=float(environment.root_positions[i, 1]))
        return first

    observation = np.array([begin(i) for i in range(environment.num_envs)])
    before = np.zeros((environment.num_envs, 1), np.float32)
    while running:
        actions = policy.act(observation)
        effort = np.abs(actions).mean(axis=1)
        jerk = np.abs(actions - before).mean(axis=1)
        before = actions
        transition = environment.step(actions)
        heights = environment.root_positions[:, 1].tolist()
        # The environment may hand out an array of its own.
        observation = transition.observation.copy()
        for i, episode in running.items():
            episode.note(heights[i], float(effort[i]), float(jerk[i]))
        for i in np.flatnonzero(transition.terminated | transition.truncated).tolist():
            if i in running:
                running[i].fell = bool(transition.terminated[i])
                finished.append(running.pop(i))
            observation[i] = begin(i)
    finished.sort(key=lambda episode: episode.number)
    return Rollout(
        lowest=np.array([episode.lowest for episode in finished]),
        rest_height=np.array([episode.rest_height for episode in finished]),
        length=np.array([episode.length for episode in finished]),
        fell=np.array([episode.fell for episode in finished]),
        effort=np.array([episode.effort / episode.length for episode in finished]),
        jerk=np.array([episode.jerk / max(episode.length - 1, 1) for episode in finished]),
    )


class _Episode:
    """One episode under way; `effort` and `jerk` are sums over its steps."""

    def __init__(self, number: int, rest_height: float) -> None:
        self.number = number
        self.rest_height = self.lowest = rest_height
        self.length = 0
        self.fell = False
        self.effort = 0.0
        self.jerk = 0.0

    def note(self, height: float, effort: float, jerk: float) -> None:
        self.lowest = min(self.lowest, height)
        self.effort += effort
        if self.length:
            self.jerk += jerk
        self.length += 1
