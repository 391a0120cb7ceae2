"""What a trained policy is worth: episodes with distinct seeds, and how the robot moved in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import fmean

from robomore.envs.measured_env import MeasuredEnv
from robomore.errors import TrainingDiverged
from robomore.identity import derive_seed
from robomore.tasks.task import Task
from robomore.training.policy import MLPPolicy
from robomore.training.rollout import rollout

_CHOICE_EPISODES = 3
"""Episodes in which policies are compared before the best is measured on others."""

_SIDE_BY_SIDE = 10
"""Episodes that run together; it saves nothing to run more in one thread."""


@dataclass(frozen=True, slots=True)
class Measurement:
    """The numbers of an evaluation that come from episodes.

    Attributes:
        fitness: mean over episodes, in m.
        episode_fitness: of each episode, in m.
        behaviour: how the robot moved, averaged over episodes, units in the names.
    """

    fitness: float
    episode_fitness: tuple[float, ...]
    behaviour: dict[str, float]


def choose(
    task: Task, parameters: tuple[float, ...], policies: Sequence[MLPPolicy], seed: int
) -> MLPPolicy:
    """Return the policy with the best fitness in episodes that no measurement uses.

    Args:
        task: says what fitness is.
        parameters: of the morphology.
        policies: from one training, the latest last; among equals the latest is taken.
        seed: as for `measure`.

    Raises:
        TrainingDiverged, UnstableSimulation: see `measure`.
    """
    if len(policies) == 1:
        return policies[0]
    apart = derive_seed(seed, "choice")
    worth = [measure(task, parameters, one, _CHOICE_EPISODES, apart).fitness for one in policies]
    return max(zip(worth, range(len(worth)), policies, strict=True), key=lambda one: one[:2])[2]


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
        TrainingDiverged: the policy does not fit the robot (the sandboxed process may write
            anything).
        UnstableSimulation: the physics diverged over and over.
    """
    env = MeasuredEnv(task, parameters, min(episodes, _SIDE_BY_SIDE))
    expected = env.observation_size, env.action_size
    if (policy.weights[0].shape[0], policy.weights[-1].shape[1]) != expected:
        raise TrainingDiverged("the policy that came out of training does not fit the robot")
    seeds = [derive_seed(seed, "episode", index) for index in range(episodes)]
    run = rollout(policy, env, seeds)
    worth = run.distance if task.fitness == "distance" else run.highest
    motions = [env.motions[seed] for seed in seeds]
    step_seconds = float(env.environment.dt)
    return Measurement(
        fitness=float(worth.mean()),
        episode_fitness=tuple(float(value) for value in worth),
        behaviour={
            "forward_distance_m": float(run.distance.mean()),
            "forward_speed_m_s": float((run.distance / (run.length * step_seconds)).mean()),
            "highest_torso_m": float(run.highest.mean()),
            "height_gain_m": float((run.highest - run.rest_height).mean()),
            "lowest_torso_m": float(run.lowest.mean()),
            "episode_seconds": float(run.length.mean() * step_seconds),
            "fell_share": float(run.fell.mean()),
            "mean_effort": float(run.effort.mean()),
            "mean_jerk": float(run.jerk.mean()),
            "energy_j": fmean(one.energy for one in motions),
            "ground_contact_share": fmean(one.ground_contact for one in motions),
            "stride_frequency_hz": fmean(one.stride_frequency for one in motions),
            "joint_amplitude_rad": fmean(one.joint_amplitude for one in motions),
        },
    )
