"""What a trained policy is worth: episodes with distinct seeds, and how the robot moved in them."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from statistics import fmean
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robomore.envs.measured_env import FALLS, SIDE_BY_SIDE, MeasuredEnv, Motion
from robomore.errors import FitnessFailed, TrainingDiverged, UnstableSimulation
from robomore.identity import derive_seed
from robomore.tasks.task import Task
from robomore.training.policy import MLPPolicy
from robomore.training.rollout import Policy, rollout

log = logging.getLogger(__name__)

_CHOICE_EPISODES = 3
"""Episodes in which policies are compared before the best is measured on others."""


@dataclass(frozen=True, slots=True)
class Measurement:
    """The numbers of an evaluation that come from episodes.

    Attributes:
        fitness: mean over episodes, in the unit of the task's fitness.
        episode_fitness: of each episode.
        behaviour: how the robot moved, averaged over episodes, units in the names.
    """

    fitness: float
    episode_fitness: tuple[float, ...]
    behaviour: dict[str, float]


def choose(
    task: Task, parameters: tuple[float, ...], policies: Iterable[MLPPolicy], seed: int
) -> MLPPolicy:
    """Return the policy with the best fitness in episodes that no measurement uses.

    Args:
        task: says what fitness is.
        parameters: of the morphology.
        policies: from one training, the latest last; among equals the latest is taken. Two at most
            are held at a time.
        seed: as for `measure`.

    Raises:
        TrainingDiverged, UnstableSimulation, FitnessFailed: of the latest, if none of several can
            be measured; see `measure`.
        ValueError: there is none.
    """
    apart = derive_seed(seed, "choice")
    fault: Exception | None = None

    def worth(policy: MLPPolicy) -> float:
        """Return the fitness; one that cannot be measured is worth less than any other."""
        nonlocal fault
        try:
            return measure(task, parameters, policy, _CHOICE_EPISODES, apart).fitness
        except (TrainingDiverged, UnstableSimulation, FitnessFailed) as error:
            log.info("one of the late policies is left out: %s", error)
            fault = error
            return -math.inf

    several = iter(policies)
    best = next(several, None)
    if best is None:
        raise ValueError("no policy")
    most: float | None = None  # one that is alone need not be measured
    for policy in several:
        if most is None:
            most = worth(best)
        fitness = worth(policy)
        if fitness >= most:
            best, most = policy, fitness
    if most == -math.inf and fault is not None:
        raise fault
    return best


def measure(
    task: Task, parameters: tuple[float, ...], policy: MLPPolicy, episodes: int, seed: int
) -> Measurement:
    """Return what `policy` is worth in `episodes` episodes of the robot, without any reward.

    Args:
        task: says what fitness is.
        parameters: of the morphology.
        policy: acts deterministically.
        episodes: how many.
        seed: the episodes' own seeds are derived from it.

    Raises:
        TrainingDiverged: an action is not a finite number, which finite weights can give too.
        UnstableSimulation: the physics diverged over and over, or a measure of it is not finite.
        FitnessFailed: the task's fitness raised, or gave no finite number.
    """
    env = MeasuredEnv(task, parameters, min(episodes, SIDE_BY_SIDE))
    seeds = [derive_seed(seed, "episode", index) for index in range(episodes)]
    return measure_in(env, task, FinitePolicy(policy.weights, policy.biases), seeds)


def measure_in(env: MeasuredEnv, task: Task, policy: Policy, seeds: Sequence[int]) -> Measurement:
    """Return what `policy` is worth in `env`, in one episode for each of `seeds`.

    Raises:
        UnstableSimulation: see `measure`.
    """
    run = rollout(policy, env, seeds)
    motions = [env.motions[seed] for seed in seeds]
    worth = np.array([one.fitness for one in motions])
    distance = np.array([one.distance for one in motions])
    highest = np.array([one.highest for one in motions])
    step_seconds = float(env.environment.dt)
    measurement = Measurement(
        fitness=float(worth.mean()),
        episode_fitness=tuple(float(value) for value in worth),
        behaviour={
            "forward_distance_m": float(distance.mean()),
            "forward_speed_m_s": float((distance / (run.length * step_seconds)).mean()),
            "highest_torso_m": float(highest.mean()),
            "height_gain_m": float((highest - run.rest_height).mean()),
            "lowest_torso_m": float(run.lowest.mean()),
            "episode_seconds": float(run.length.mean() * step_seconds),
            "fell_share": float(run.fell.mean()),
            "mean_effort": float(run.effort.mean()),
            "mean_jerk": float(run.jerk.mean()),
            "energy_j": fmean(one.energy for one in motions),
            "ground_contact_share": fmean(one.ground_contact for one in motions),
            "stride_frequency_hz": fmean(one.stride_frequency for one in motions),
            "joint_amplitude_rad": fmean(one.joint_amplitude for one in motions),
            "saturated_share": fmean(one.saturation for one in motions),
            **_sideways(motions),
            **_falls(motions),
        },
    )
    numbers = (*measurement.episode_fitness, *measurement.behaviour.values())
    if not all(map(math.isfinite, numbers)):
        raise UnstableSimulation("the robot's motion is not measured in finite numbers")
    return measurement


def _sideways(motions: Sequence[Motion]) -> dict[str, float]:
    """Return how far a robot in three dimensions moves sideways and turns."""
    drifts = [one.drift for one in motions if one.drift is not None]
    turns = [one.turn for one in motions if one.turn is not None]
    if not drifts or not turns:
        return {}
    return {"sideways_drift_m": fmean(drifts), "turn_rad": fmean(turns)}


def _falls(motions: Sequence[Motion]) -> dict[str, float]:
    """Return the share of the episodes that ended early for each reason that there was."""
    counts = {name: sum(one.fall == name for one in motions) for name in FALLS}
    return {f"fell_{name}_share": n / len(motions) for name, n in counts.items() if n}


class FinitePolicy(MLPPolicy):
    """A policy that raises where an action is no finite number."""

    def act(self, observations: NDArray[np.floating[Any]]) -> NDArray[np.float32]:
        with np.errstate(over="ignore", invalid="ignore"):
            actions = super().act(observations)
        if not np.isfinite(actions).all():
            raise TrainingDiverged(
                "the policy that came out of training gives actions that are not finite numbers"
            )
        return actions
