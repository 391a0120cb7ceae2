"""From a robot's states to a trajectory: where its root and its parts are, and how it leans."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from robots import ours

from robomore.envs.measured_env import MeasuredEnv
from robomore.envs.recorder import Recorder
from robomore.errors import InputError
from robomore.tasks import Fitness, Trajectory, get_task


def recorded(task: str, changes: dict[int, float]) -> Trajectory:
    """Return an episode of two samples: the rest pose, and the same with changed positions."""
    robot = ours(task)
    start = np.concatenate((robot.init_qpos, robot.init_qvel))
    end = start.copy()
    for index, value in changes.items():
        end[index] = value
    return Recorder(robot).trajectory(
        np.stack((start, end)),
        np.zeros(1),
        np.zeros(1, np.bool_),
        step_seconds=0.1,
        full_steps=1,
        fall="",
    )


def test_a_free_robot_is_where_its_state_says_and_leans_by_its_quaternion() -> None:
    turned, tipped = 0.9, 0.7
    moved = recorded("ant", {0: 2.0, 1: -1.0, 2: 3.0, 3: np.cos(0.35), 4: np.sin(tipped / 2)})
    np.testing.assert_allclose(moved.position[1], (2.0, -1.0, 3.0))
    assert moved.upright == pytest.approx([1.0, np.cos(tipped)])
    about = recorded("ant", {3: np.cos(turned / 2), 6: np.sin(turned / 2)})
    assert about.upright == pytest.approx([1.0, 1.0]), "turning about the vertical is not leaning"


def test_a_planar_robot_leans_by_its_angle_and_a_swimmer_moves_sideways() -> None:
    hopper = recorded("hopper", {2: 0.5})
    assert hopper.upright == pytest.approx([1.0, np.cos(0.5)])
    assert (hopper.position[:, 1] == 0).all()
    swimmer = recorded("swimmer", {1: 1.5, 2: 0.8})
    assert swimmer.position[1, 1] - swimmer.position[0, 1] == pytest.approx(1.5)
    assert swimmer.upright == pytest.approx([1.0, 1.0])


def test_parts_are_found_by_name() -> None:
    hopper = recorded("hopper", {0: 1.0})
    np.testing.assert_allclose(hopper.where("foot")[:, 2], 0.1, atol=1e-12)
    np.testing.assert_allclose(hopper.where("foot_geom")[:, 0], [0.065, 1.065])
    assert hopper.where("") is hopper.position
    with pytest.raises(InputError, match=r"no part 'foott'. Did you mean 'foot'\? It has torso"):
        hopper.where("foott")


def test_an_episode_is_worth_what_the_task_says() -> None:
    frugal = Fitness.sum((1.0, "distance"), (-0.5, "energy"))
    task = replace(get_task("half-cheetah"), episode_steps=20, fitness=frugal)
    env = MeasuredEnv(task, task.reference, 1)
    env.reset_one(0, 5)
    x = env.root_positions[0, 0]
    random = np.random.default_rng(0)
    for _ in range(20):
        env.step(random.uniform(-1, 1, (1, env.action_size)))
    motion = env.motions[5]
    assert motion.energy > 1
    expected = env.root_positions[0, 0] - x - 0.5 * motion.energy
    assert motion.fitness == pytest.approx(expected, abs=1e-12)
