"""Can a morphology be simulated? Found by trying, before any training is spent on it.

No rule of thumb forbids a thin or a long limb: whether the physics holds depends on the fluid, the
motors and every other part. So the robot is driven by random torques for a moment, as training
does first.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robomore.envs.silent import silent_mujoco
from robomore.envs.vector_env import VectorEnv
from robomore.errors import InvalidMorphology, UnstableSimulation
from robomore.tasks.task import Task

NUM_ENVS, STEPS = 4, 250
"""Simulations, and control steps of each: a fifth of a second of computing for Ant."""

TOLERATED = 1
"""Divergences in the try that are put up with. Training begins with as random actions and gives up
after 10 divergences, which at 2 in 1000 steps are reached within its first 5000.

Of 300 random morphologies, each parameter spread over its whole range of allowed values, 10 of 60
Swimmers diverged and none of 240 others did. None of the 75 published morphologies does."""

STARTS = 4
"""Starts of each simulation in which the robot has to stay healthy at least once."""

AT_ONCE = 2
"""Control steps at rest within which an episode ends at once: no robot can fall so early."""


def try_out(task: Task, parameters: Sequence[float]) -> None:
    """Drive a robot by random torques for a moment; the same try for the same morphology.

    Args:
        task: whose robot it is.
        parameters: of its morphology, valid ones.

    Raises:
        InvalidMorphology: it is unhealthy at or just after the start of every episode.
        UnstableSimulation: the physics diverged more than once.
    """
    env = VectorEnv(task, parameters, NUM_ENVS)
    with silent_mujoco():
        _check_starts(task, env)
        _drive(env)


def _drive(env: VectorEnv) -> None:
    random = np.random.default_rng(0)
    env.reset(0)
    where = ""
    for step in range(STEPS):
        before = env.physics_state.copy()
        env.step(random.uniform(-1, 1, (NUM_ENVS, env.action_size)))
        if env.diverged.any() and not where:
            where = _fastest_part(env, before[np.flatnonzero(env.diverged)[0]])
        if env.divergences > TOLERATED:
            raise UnstableSimulation(
                f"The physics diverged {env.divergences} times within {NUM_ENVS * (step + 1)} "
                f"control steps of random torques, first at {where}. A part is too light for the "
                "forces on it (motors, fluid, contacts) at this time step: make that part, or the "
                "parts beside it, thicker or longer"
            )


def _check_starts(task: Task, env: VectorEnv) -> None:
    environment = env.environment
    if not env.environment.judges_health() or not env.terminates:
        return
    heights = []
    for seed in range(STARTS):
        env.reset(seed)
        heights += env.root_positions[:, 1].tolist()
        healthy = environment.batch_healthy(env.physics_state)
        for _ in range(AT_ONCE):
            healthy &= ~env.step(np.zeros((NUM_ENVS, env.action_size))).terminated
        if healthy.any() or env.diverged.any():
            return
    limits = getattr(environment, "_healthy_z_range", None)
    allowed = f"; healthy is {limits[0]:g} to {limits[1]:g} m" if limits else ""
    raise InvalidMorphology(
        f"{task.id}: the robot is unhealthy within {AT_ONCE} control steps of all {len(heights)} "
        f"episodes that were tried, so that each ends at once: its torso starts "
        f"{min(heights):.3g} to {max(heights):.3g} m high{allowed}"
    )


def _fastest_part(env: VectorEnv, state: NDArray[np.float64]) -> str:
    """Return the joint that moved fastest in `state` (nq + nv,), and the part that it moves."""
    model = env.model
    degree = int(np.argmax(np.abs(state[model.nq :])))
    joint = model.joint(int(model.dof_jntid[degree]))
    part = model.body(int(model.dof_bodyid[degree]))
    return f"joint {joint.name!r} of part {part.name!r}, which weighs {part.mass[0]:.3g} kg"
