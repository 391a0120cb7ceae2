"""Energy, ground contact and stride of robots whose motion is known."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from robomore.envs.measured_env import MeasuredEnv, Motion, angle_between, stride
from robomore.envs.vector_env import VectorEnv
from robomore.tasks import Fitness, get_task


def driven(env: VectorEnv, steps: int) -> np.ndarray:
    time = np.arange(steps) * float(env.environment.dt)
    swing = np.sin(2 * np.pi * 1.5 * time)
    for value in swing:
        env.step(np.full((env.num_envs, env.action_size), 0.3 * value))
    return env.physics_state.copy()


@pytest.mark.parametrize("task", ["half-cheetah", "hopper", "ant"])
def test_measuring_changes_nothing(task: str) -> None:
    chosen = get_task(task)
    plain = VectorEnv(chosen, chosen.reference, 2, auto_reset=False)
    measured = MeasuredEnv(chosen, chosen.reference, 2)
    for env in (plain, measured):
        for index in range(2):
            env.reset_one(index, 7 + index)
    assert (driven(plain, 20) == driven(measured, 20)).all()


def test_an_episode_of_a_swimmer_costs_energy_and_touches_nothing() -> None:
    task = replace(get_task("swimmer"), episode_steps=200)
    env = MeasuredEnv(task, task.reference, 1)
    env.reset_one(0, 3)
    driven(env, task.episode_steps)
    motion = env.motions[3]
    assert motion.ground_contact == 0
    assert motion.stride_frequency == pytest.approx(1.5, abs=0.05)
    # What the fluid took. With resting motors nothing is spent.
    assert motion.energy > 0
    env.reset_one(0, 4)
    for _ in range(task.episode_steps):
        env.step(np.zeros((1, env.action_size)))
    assert env.motions[4].energy == 0


@pytest.fixture
def weightless() -> MeasuredEnv:
    """A swimmer at rest in no fluid, where all work of its motors becomes kinetic energy."""
    task = get_task("swimmer")
    env = MeasuredEnv(task, task.reference, 1)
    env.reset_one(0, 0)
    env.model.opt.density = env.model.opt.viscosity = 0
    env.model.dof_armature[:] = env.model.dof_damping[:] = 0
    env.model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    env.data[0].qvel[:] = 0
    return env


def kinetic(env: MeasuredEnv) -> float:
    mujoco.mj_forward(env.model, env.data[0])
    return float(env.data[0].energy[1])


def test_the_work_of_a_motor_is_the_energy_of_what_it_turns(weightless: MeasuredEnv) -> None:
    for _ in range(5):
        weightless.step(np.array([[0.2, 0.0]]))
    assert sum(weightless._energy[0]) == pytest.approx(kinetic(weightless), rel=0.05)


def test_braking_costs_as_much_as_driving(weightless: MeasuredEnv) -> None:
    for _ in range(5):
        weightless.step(np.array([[0.2, 0.0]]))
    most = kinetic(weightless)
    for _ in range(5):
        weightless.step(np.array([[-0.2, 0.0]]))
    assert kinetic(weightless) < 0.02 * most, "it rests again"
    assert sum(weightless._energy[0]) == pytest.approx(2 * most, rel=0.05)


def test_motors_that_work_against_each_other_both_cost(weightless: MeasuredEnv) -> None:
    """One drives and the other one brakes, so that hardly any is won or lost on the whole."""
    model, data = weightless.model, weightless.data[0]
    front, back = (model.jnt_dofadr[model.actuator_trnid[motor, 0]] for motor in range(2))
    data.qvel[front], data.qvel[back] = 2.0, 2.0
    before = kinetic(weightless)
    weightless.step(np.array([[0.02, -0.02]]))
    gear, time = float(model.actuator_gear[0, 0]), float(weightless.environment.dt)
    one = 0.02 * gear * 2.0 * time
    assert abs(kinetic(weightless) - before) < 0.3 * one
    assert weightless._energy[0][0] == pytest.approx(2 * one, rel=0.1)


def test_a_robot_that_stands_touches_the_ground() -> None:
    task = replace(get_task("half-cheetah"), episode_steps=200)
    env = MeasuredEnv(task, task.reference, 1)
    env.reset_one(0, 0)
    for _ in range(task.episode_steps):
        env.step(np.zeros((1, env.action_size)))
    assert env.motions[0].ground_contact > 0.9


def test_stride_finds_frequency_and_amplitude() -> None:
    time = np.arange(1000) * 0.05
    angles = np.stack((0.4 * np.sin(2 * np.pi * 2 * time), np.full_like(time, 0.7)), axis=1)
    frequency, amplitude = stride(angles, 0.05)
    assert frequency == pytest.approx(2, abs=0.03)
    assert amplitude == pytest.approx(0.2, rel=0.01)
    assert stride(angles[:5], 0.05) == (0.0, 0.0)
    assert stride(np.full((100, 2), 0.3), 0.05) == pytest.approx((0.0, 0.0))


def ended(task: str, qpos: dict[int, float], qvel: float = 0.0, steps: int = 1) -> Motion:
    """Return the motion of an episode whose robot is put somewhere before the last step."""
    chosen = replace(get_task(task), episode_steps=steps)
    env = MeasuredEnv(chosen, chosen.reference, 1)
    env.reset_one(0, 0)
    env.data[0].qvel[:] = qvel
    for index, value in qpos.items():
        env.data[0].qpos[index] = value
    actions = np.full((1, env.action_size), -0.5)
    actions[0, 0] = 1.0
    for _ in range(steps):
        env.step(actions)
    return env.motions[0]


@pytest.mark.parametrize(
    ("task", "qpos", "qvel", "fall"),
    [
        ("ant", {2: 3.0}, 0.0, "too_high"),
        ("hopper", {1: 0.2}, 0.0, "too_low"),
        ("hopper", {2: 2.5}, 0.0, "tilted"),
        ("hopper", {1: 9.0}, 120.0, "unhealthy"),
        ("ant", {}, 1e9, "diverged"),
        ("ant", {}, 0.0, ""),
        ("half-cheetah", {1: -3.0}, 0.0, ""),
    ],
)
def test_the_reason_of_an_early_end_is_found(
    task: str, qpos: dict[int, float], qvel: float, fall: str
) -> None:
    assert ended(task, qpos, qvel).fall == fall


def test_drift_turn_and_saturation_are_measured() -> None:
    quarter = {3: np.cos(np.pi / 4), 4: 0.0, 5: 0.0, 6: np.sin(np.pi / 4)}
    motion = ended("ant", {1: -2.0, **quarter})
    assert motion.drift == pytest.approx(2, abs=0.2)
    assert motion.turn == pytest.approx(np.pi / 2, abs=0.3)
    assert motion.saturation == pytest.approx(1 / 8)
    planar = ended("hopper", {}, steps=3)
    assert planar.drift is None and planar.turn is None
    assert planar.saturation == pytest.approx(1 / 3)
    assert angle_between(3.0, -3.0) == pytest.approx(2 * np.pi - 6)


def thrown(fitness: str | Fitness, before: dict[int, float], speed: dict[int, float]) -> Motion:
    """Return the motion of an Ant-Jump that is moved in its second step and thrown in its third."""
    task = replace(get_task("ant-jump"), episode_steps=3, fitness=fitness)
    env = MeasuredEnv(task, task.reference, 1)
    env.reset_one(0, 0)
    env.step(np.zeros((1, 8)))
    for index, value in before.items():
        env.data[0].qpos[index] = value
    env.step(np.zeros((1, 8)))
    for index, value in speed.items():
        env.data[0].qvel[index] = value
    env.step(np.zeros((1, 8)))
    return env.motions[0]


START, NOISE = 0.716, 0.101
"""Height of an Ant's torso when an episode starts, and how far noise moves it, in m."""


@pytest.mark.parametrize(
    ("fitness", "worth"),
    [
        ("distance", 0.0),
        ("height", START),
        ("terrain-covered", 0.0),
        ("height-climbed", 0.0),
        ("time-upright", 0.05),
        ("transport-economy", 0.0),
        (Fitness.of("speed-kept", speed=1.0), 0.0),
        (Fitness.of("target-reached", target=(9.0, 0.0), radius=1.0), 0.0),
        (Fitness.of("path-followed", path=[(0.0, 0.0), (90.0, 0.0)], width=5.0), 0.0),
        (Fitness.sum((1.0, "distance"), (-1.0, "energy")), 0.0),
        (Fitness.own(lambda seen: seen.qpos[1:, 0].max(), unit="m", meaning="how far"), 0.0),
    ],
)
def test_whatever_was_before_a_blow_up_is_not_paid_for(
    fitness: str | Fitness, worth: float
) -> None:
    motion = thrown(fitness, {0: 9.0, 2: 90.0}, {0: 1e9})
    assert motion.fall == "diverged"
    # One step in which nothing moves; a path that begins at 0 is followed as far as noise goes.
    assert motion.fitness == pytest.approx(worth, abs=NOISE)
    assert motion.distance == 0 and motion.highest == pytest.approx(START, abs=NOISE)
    # What is put there without an end of that kind counts.
    kept = thrown("height", {0: 9.0, 2: 90.0}, {})
    assert kept.fall == "" and kept.fitness == kept.highest == pytest.approx(90, abs=0.5)
    assert kept.distance == pytest.approx(9, abs=0.2)


def test_the_throw_that_ends_an_episode_is_not_paid_for() -> None:
    motion = thrown("height", {0: 5.0, 2: 20.0}, {0: 9e5, 2: 9e5})
    assert motion.fall == "too_high"
    assert motion.fitness == motion.highest == pytest.approx(20, abs=0.5)
    assert motion.distance == pytest.approx(5, abs=0.2)
    # In the first step of an episode, too, which leaves nothing but the start.
    at_once = ended("ant-jump", {2: 500.0})
    assert at_once.fall == "too_high"
    assert at_once.fitness == pytest.approx(START, abs=NOISE) and at_once.distance == 0
