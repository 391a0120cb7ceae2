"""One episode of a trained design, as the poses that it went through."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.cli.trained_design import TrainedDesign
from robomore.envs.vector_env import VectorEnv
from robomore.errors import InputError
from robomore.runs.words import number


@dataclass(frozen=True)
class Recording:
    """An episode.

    Attributes:
        performer: who moves.
        model: of its body.
        poses: (steps + 1, nq) joint positions, the first one after the reset.
        dt: seconds between two poses.
        told: what happened, in words.
    """

    performer: TrainedDesign
    model: mujoco.MjModel
    poses: NDArray[np.float64]
    dt: float
    told: str


def record(performer: TrainedDesign, seed: int) -> Recording:
    """Roll a policy out for one episode.

    Raises:
        InputError: the policy was trained for another robot.
    """
    task = performer.task
    simulations = VectorEnv(task, performer.parameters, 1, auto_reset=False)
    weights = performer.policy.weights
    fits = (weights[0].shape[0], weights[-1].shape[1])
    if fits != (simulations.observation_size, simulations.action_size):
        raise InputError(
            f"the policy takes {fits[0]} observations and gives {fits[1]} actions, this robot has "
            f"{simulations.observation_size} and {simulations.action_size}; play it with its own "
            "design.json"
        )
    observation = simulations.reset_one(0, seed)[None]
    data = simulations.data[0]
    poses, roots, fell = [data.qpos.copy()], [simulations.root_positions[0]], False
    for _ in range(task.episode_steps):
        transition = simulations.step(performer.policy.act(observation))
        observation = transition.final_observation
        poses.append(data.qpos.copy())
        roots.append(simulations.root_positions[0])
        fell = bool(transition.terminated[0])
        if fell or transition.truncated[0]:
            break
    dt = float(simulations.environment.dt)
    seconds = (len(poses) - 1) * dt
    path = np.array(roots)
    told = f"{number(path[-1, 0] - path[0, 0], 3)} m forward in {number(seconds, 3)} s"
    if task.fitness == "height":
        told = f"{number(path[:, 1].max(), 3)} m high, {told}"
    told += ", then it fell" if fell else ""
    return Recording(performer, simulations.model, np.array(poses), dt, told)
