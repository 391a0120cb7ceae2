"""Does a task keep what a `Task` promises? Tried by compiling and moving its robot, untrained."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robomore.envs.compile import body_facts, compile_model, model_volume
from robomore.envs.measured_env import MeasuredEnv
from robomore.envs.reward_text import reward_function
from robomore.envs.silent import silent_mujoco
from robomore.envs.try_out import try_out
from robomore.envs.vector_env import VectorEnv
from robomore.errors import (
    FitnessFailed,
    InvalidMorphology,
    InvalidReward,
    RewardFailed,
    UnstableSimulation,
)
from robomore.rewards.continuation import check_continuation
from robomore.search.random import drawn
from robomore.tasks import Task
from robomore.tasks.fingerprint import fingerprint

DRAWS = 8
"""Morphologies around the reference that are compiled and moved."""

_SAME_VOLUME = 0.01
"""Relative difference between volumes that is put up with."""

MOVES = 20
"""Control steps with random actions of each."""


def check_task(task: Task) -> None:
    """Check that a task keeps its contract: values, volume, simulation and reward.

    Raises:
        AssertionError: with one sentence on what is wrong.
    """
    assert task.parameters, "a task needs at least one free parameter"
    assert len(set(task.names)) == len(task.names), f"two parameters have one name: {task.names}"
    for parameter in task.parameters:
        assert parameter.low < parameter.high, f"{parameter.name}: low has to be below high"
        assert parameter.low <= parameter.reference <= parameter.high, (
            f"{parameter.name}: the reference {parameter.reference} is outside its bounds"
        )
        low, high = parameter.search or (parameter.low, parameter.high)
        assert parameter.low <= low <= parameter.reference <= high <= parameter.high, (
            f"{parameter.name}: the search range must hold the reference and lie within the bounds"
        )
        assert parameter.scale == "linear" or low > 0, (
            f"{parameter.name}: a log scale needs a low end of the search range above 0"
        )
        assert parameter.meaning, f"{parameter.name} has no meaning; a designer has to be told one"
    reference = task.check(task.reference)
    assert fingerprint(task) == fingerprint(task), "the fingerprint changes from call to call"
    assert task.volume(reference) > 0, "the reference robot has no volume"
    _check_volume(task, reference)
    assert body_facts(task, reference)["mass"] > 0, "the reference robot has no mass"
    with silent_mujoco():
        _check_try(task, reference)
        for seed in range(DRAWS):
            parameters = drawn(task, seed, deviation=0.1).parameters
            volume = task.volume(parameters)
            assert math.isfinite(volume) and volume > 0, f"{parameters} has the volume {volume}"
            _check_volume(task, parameters)
            _check_motion(task, parameters, seed)
        _check_motion(task, reference, DRAWS)
        _check_episode(task, reference)
    try:
        check_continuation(task, reference, reward_function(task.reward))
    except (InvalidReward, RewardFailed) as error:
        raise AssertionError(f"the reference reward: {error}") from None
    outside = [parameter.high + 1.0 for parameter in task.parameters]
    try:
        task.check(outside)
    except InvalidMorphology:
        return
    raise AssertionError("parameters beyond their bounds are accepted")


def _check_volume(task: Task, parameters: tuple[float, ...]) -> None:
    """Compare the volume that is told with the solids of the compiled robot."""
    told = task.volume(parameters)
    solid = model_volume(compile_model(task, parameters))
    if abs(told - solid) <= _SAME_VOLUME * solid:
        return
    listed, remedy = (
        ("`shapes` have", "leave `shapes` out, and the template's solids count")
        if task.shapes is not None
        else ("template is read as", "give `shapes` that say what the robot is made of")
    )
    where = "" if parameters == task.reference else f" with {_named(task, parameters)}"
    raise AssertionError(
        f"its {listed} {told:.6g} m³ and the robot's solids {solid:.6g} m³{where}, so every "
        f"efficiency would be wrong; {remedy}"
    )


def _named(task: Task, parameters: tuple[float, ...]) -> str:
    return ", ".join(f"{name} = {value:.4g}" for name, value in task.named(parameters).items())


def _check_try(task: Task, parameters: tuple[float, ...]) -> None:
    """Check that the reference can be simulated, and that its episodes do not end at once."""
    try:
        try_out(task, parameters)
    except InvalidMorphology as error:
        raise AssertionError(f"the reference robot: {error}") from None
    except UnstableSimulation as error:
        raise AssertionError(f"the reference robot: {_steadied(task, error)}") from None


def _steadied(task: Task, error: UnstableSimulation) -> str:
    """Return what is said of physics that diverge, with what the robot's file can do about it."""
    step = float(compile_model(task, task.reference).opt.timestep)
    return (
        f"{str(error).rstrip('.')}. In the robot's MJCF, such as the robot.xml that "
        "`robomore new` writes, there are other remedies: give its joints armature and damping "
        '(<default><joint armature="0.01" damping="0.2"/></default>, for '
        f'example), or a smaller time step (<option timestep="{step / 2:g}"/>; it is {step:g} s '
        "now), or, if its motors are stronger than it needs, weaker ones (a smaller kp or gear)"
    )


def _check_episode(task: Task, parameters: tuple[float, ...]) -> None:
    """Check that an episode of the reference has a fitness, whose motors get random actions."""
    env = MeasuredEnv(task, parameters, 1)
    random = np.random.default_rng(0)
    env.reset_one(0, 0)
    try:
        for _ in range(task.episode_steps):
            moved = env.step(random.uniform(-1, 1, (1, env.action_size)))
            if moved.terminated[0] or moved.truncated[0]:
                break
    except FitnessFailed as error:
        raise AssertionError(str(error)) from None


def _check_motion(task: Task, parameters: tuple[float, ...], seed: int) -> None:
    """Move the robot at random under the reference reward, twice with the same seed."""
    try:
        seen = [_moved(task, parameters, seed) for _ in range(2)]
    except RewardFailed as error:
        raise AssertionError(f"the reference reward: {error}") from None
    except UnstableSimulation as error:
        named = _named(task, parameters)
        raise AssertionError(f"the robot with {named}: {_steadied(task, error)}") from None
    assert np.isfinite(seen[0]).all(), f"an observation of {parameters} is not a finite number"
    assert np.array_equal(seen[0], seen[1]), "the same seed and actions give another motion"


def _moved(task: Task, parameters: tuple[float, ...], seed: int) -> NDArray[np.float64]:
    """Return what is observed of two robots (moves, 2, size) that are moved at random."""
    env = VectorEnv(task, parameters, 2, reward_function(task.reward))
    assert env.action_size > 0, "the robot has no motors"
    random = np.random.default_rng(seed)
    observations = [env.reset(seed)]
    for _ in range(MOVES):
        moved = env.step(random.uniform(-1, 1, (2, env.action_size)))
        observations.append(moved.observation)
        assert np.isfinite(moved.reward).all(), "the reference reward is not a finite number"
    return np.stack(observations)
