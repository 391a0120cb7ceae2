"""One episode of a moving robot, as the poses that it went through."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.envs.vector_env import VectorEnv
from robomore.tasks import Task

Act = Callable[[NDArray[Any]], NDArray[Any]]
"""A policy: actions (n, actions) in [-1, 1] for observations (n, observations)."""


@dataclass(frozen=True)
class Recording:
    """An episode.

    Attributes:
        task: what the robot is for.
        parameters: of its morphology, in the task's order.
        title: for people.
        model: of the robot.
        poses: (steps + 1, nq) joint positions, the first one after the reset.
        roots: (steps + 1, 2) x and height of the torso, in m.
        dt: seconds between two poses.
        fell: whether the episode ended because the robot was no longer healthy.
    """

    task: Task
    parameters: tuple[float, ...]
    title: str
    model: mujoco.MjModel
    poses: NDArray[np.float64]
    roots: NDArray[np.float64]
    dt: float
    fell: bool

    @property
    def distance(self) -> float:
        """Forward way of the torso, in m."""
        return float(self.roots[-1, 0] - self.roots[0, 0])

    @property
    def height(self) -> float:
        """Highest torso height, in m."""
        return float(self.roots[:, 1].max())

    @property
    def seconds(self) -> float:
        """Length of the episode."""
        return (len(self.poses) - 1) * self.dt

    def first(self, seconds: float) -> Recording:
        """Return the beginning of the episode, or all of it if it is not longer than that."""
        length = round(seconds / self.dt) + 1
        if length >= len(self.poses):
            return self
        return replace(self, poses=self.poses[:length], roots=self.roots[:length], fell=False)


def record(
    task: Task, parameters: tuple[float, ...], act: Act, title: str, seed: int = 0
) -> Recording:
    """Roll a policy out for one episode.

    Args:
        task: what the robot is for.
        parameters: of its morphology, in the task's order.
        act: the policy.
        title: for people.
        seed: of the episode's start.
    """
    env = VectorEnv(task, parameters, 1, auto_reset=False)
    observation = env.reset_one(0, seed)[None]
    data = env.data[0]
    poses, roots, fell = [data.qpos.copy()], [env.root_positions[0]], False
    for _ in range(task.episode_steps):
        transition = env.step(act(observation))
        observation = transition.final_observation
        poses.append(data.qpos.copy())
        roots.append(env.root_positions[0])
        fell = bool(transition.terminated[0])
        if fell or transition.truncated[0]:
            break
    return Recording(
        task=task,
        parameters=parameters,
        title=title,
        model=env.model,
        poses=np.array(poses),
        roots=np.array(roots),
        dt=float(env.environment.dt),
        fell=fell,
    )
