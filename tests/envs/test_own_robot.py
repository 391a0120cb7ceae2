"""The environment of a robot of one's own: spaces, names, health and control ranges."""

from __future__ import annotations

import warnings
from pathlib import Path

import mujoco
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from dog import write_arm, write_dog
from robomore.envs.control_map import ControlMap
from robomore.envs.registration import make_environment
from robomore.envs.reward_text import reward_function
from robomore.envs.robots.own_robot import OwnRobotEnvironment
from robomore.envs.vector_env import VectorEnv
from robomore.errors import InputError
from robomore.importer.proposal import write_proposal
from robomore.importer.reading import read_robot
from robomore.importer.task_file import read_task
from robomore.tasks import Task, get_task


@pytest.fixture(scope="module")
def dog(tmp_path_factory: pytest.TempPathFactory) -> Task:
    folder = tmp_path_factory.mktemp("dog")
    source = write_dog(folder)
    file = write_proposal(read_robot(source), source, folder / "dog")
    file.write_text(file.read_text().replace("control_hz", 'sensors = ["gyro"]\ncontrol_hz'))
    return read_task(file)


def made(task: Task) -> OwnRobotEnvironment:
    return OwnRobotEnvironment(task, task.reference, reward_function(task.reward))


def test_gymnasium_accepts_it(dog: Task) -> None:
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*Box observation space m.*")
        check_env(made(dog), skip_render_check=True)


def test_it_starts_on_the_floor_whatever_the_morphology(dog: Task) -> None:
    for scale in (0.5, 1.0, 2.0):
        values = {one.name: one.reference * scale for one in dog.parameters}
        env = OwnRobotEnvironment(dog, values, reward_function(dog.reward), reset_noise=0.0)
        env.reset(seed=0)
        assert env.root_height == env.rest_height
        distances = [
            mujoco.mj_geomDistance(env.model, env.data, 0, geom, 10, None)
            for geom in range(1, env.model.ngeom)
        ]
        assert min(distances) == pytest.approx(0.003, abs=1e-6)


def test_economy_pays_for_speed_and_charges_for_power(dog: Task, tmp_path: Path) -> None:
    source = write_dog(tmp_path)
    file = write_proposal(read_robot(source), source, tmp_path / "dog", goal="economy")
    task = read_task(file)
    assert task.goal.name == "transport-economy"
    assert "as little energy as possible" in task.description
    env = made(task)
    env.reset(seed=0)
    weight = 9.81 * float(env.model.body_mass.sum())
    for _ in range(5):
        *_, info = env.step(env.action_space.sample())
        watts = np.abs(env.data.actuator_force * env.data.actuator_velocity).sum()
        assert info["power"] == pytest.approx(-watts / (12 * weight), rel=0.05)
        assert info["forward"] <= 3.0
    arm = write_arm(tmp_path)
    with pytest.raises(InputError, match="--goal economy is for a robot that moves freely"):
        write_proposal(read_robot(arm, "fixed"), arm, tmp_path / "arm", goal="economy")


def test_one_and_many_observe_alike(dog: Task) -> None:
    one, many = made(dog), VectorEnv(dog, dog.reference, 2)
    alone, _ = one.reset(seed=5)
    np.testing.assert_array_equal(many.reset_one(0, 5), alone)
    many.reset_one(1, 6)
    random = np.random.default_rng(0)
    for _ in range(20):
        action = random.uniform(-1, 1, (2, 8))
        seen = many.step(action).final_observation[0]
        np.testing.assert_allclose(seen, one.step(action[0])[0], atol=1e-9)
    size = 1 + 3 + 3 + 3 + 3 + 8 + 8 + 8 + 4 + 3  # the last ones: contacts, and the gyro
    assert len(seen) == size
    np.testing.assert_allclose(seen[29:37], action[0])


def test_named_access(dog: Task) -> None:
    env = made(dog)
    env.reset(seed=0)
    for _ in range(25):
        env.step(np.zeros(8))
    knee = env.joint("FL_knee")
    assert knee.angle == env.data.joint("FL_knee").qpos[0]
    assert abs(knee.torque) <= 20
    weight = 9.81 * float(env.model.body_mass.sum())
    forces = [env.contact_force(name) for name in env.contact_names]
    assert env.contact_names == ("FL_foot", "FR_foot", "RL_foot", "RR_foot")
    assert sum(forces) == pytest.approx(weight, rel=0.3)
    assert all(map(env.touches, env.contact_names))
    assert env.sensor("gyro").shape == (3,)
    assert env.home_angle("FL_knee") == pytest.approx(-1.8)
    assert abs(env.heading) < 0.2 and env.tilt < 0.2 and env.is_healthy
    with pytest.raises(KeyError, match="no joint is called 'FL_nee'; there are: FL_hip"):
        env.joint("FL_nee")


def test_a_reward_uses_the_names_in_training(dog: Task) -> None:
    text = """def _get_rew(self, x_velocity, action):
    force = self.contact_force("FL_foot") + self.joint("FL_knee").torque
    return force, {"force": force, "tilt": self.tilt}
"""
    env = VectorEnv(dog, dog.reference, 2, reward_function(text))
    env.reset(0)
    for _ in range(5):
        env.step(np.zeros((2, 8)))
    assert env.reward_statistics()["force"].high > 0


def test_a_robot_that_lies_on_its_back_is_not_healthy(dog: Task) -> None:
    env = made(dog)
    env.reset(seed=0)
    env.data.qpos[3:7] = 0, 1, 0, 0
    assert env.tilt == pytest.approx(np.pi) and not env.is_healthy
    env.data.qpos[3:7], env.data.qpos[2] = (1, 0, 0, 0), 0.05
    assert not env.is_healthy


def test_actions_reach_all_of_a_servos_range(dog: Task) -> None:
    env = OwnRobotEnvironment(dog, dog.reference, reward_function(dog.reward), reach=1.0)
    control = env.control_map()
    assert control.controls(np.ones(8))[:2] == pytest.approx((2.5, -0.9))
    assert control.controls(-np.ones(8))[:2] == pytest.approx((-0.7, -2.7))
    assert control.controls(np.zeros(8))[:2] == pytest.approx(env.init_qpos[7:9])
    half = ControlMap(env.model, env.init_qpos, reach=0.5)
    assert half.controls(np.ones(8))[1] == pytest.approx((-1.8 - 0.9) / 2, abs=1e-6)
    actions = np.linspace(-0.9, 0.9, 8)
    np.testing.assert_allclose(control.actions(control.controls(actions)), actions)


def test_official_robots_take_actions_as_they_are() -> None:
    for id in ("ant", "hopper", "half-cheetah", "swimmer", "walker"):
        env = make_environment(id)
        assert env.control_map().is_identity
        assert get_task(id).shapes is None


def test_an_arm_reaches_for_its_target(tmp_path: Path) -> None:
    source = write_arm(tmp_path)
    file = write_proposal(read_robot(source, "fixed"), source, tmp_path / "arm")
    task = read_task(file)
    assert task.goal.name == "target-reached"
    env = made(task)
    env.reset(seed=0)
    away = env.data.body("tool").xpos - np.array([0.12, 0.07, 0.12])
    assert env.target_distance == pytest.approx(float(np.linalg.norm(away)))
    assert not env.step(np.ones(1))[2], "an arm does not fall"
