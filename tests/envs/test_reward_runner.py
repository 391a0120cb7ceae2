"""Rewards run once per simulation: what they may read, keep and return."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from robots import OFFICIAL, reference, simulations

from robomore.envs.reward_text import reward_function
from robomore.envs.vector_env import VectorEnv
from robomore.errors import RewardFailed
from robomore.tasks import get_task

HEADER = "def _get_rew(self, x_velocity, action):\n"


def run(body: str, task: str = "ant", steps: int = 1) -> VectorEnv:
    """Simulations that have done some steps under a reward with this body."""
    lines = "".join(f"    {line}\n" for line in body.strip().splitlines())
    batch = simulations(task, 2, reward_function(HEADER + lines))
    batch.reset(0)
    random = np.random.default_rng(0)
    for _ in range(steps):
        batch.step(random.uniform(-1, 1, (2, batch.action_size)))
    return batch


def value_of(expression: str, task: str = "ant") -> float:
    return (
        run(f"return float({expression}), {{'it': float({expression})}}", task)
        .reward_statistics()["it"]
        .high
    )


@pytest.mark.parametrize(
    "expression",
    [
        "self.data.qpos[2]",
        "self.data.qvel.flat[3]",
        "self.data.body('torso').xpos[0]",
        "self.data.body(1).xmat[0]",
        "self.data.joint('hip_1').qpos[0]",
        "self.data.cfrc_ext.sum()",
        "self.data.body('torso').cfrc_ext.sum()",
        "self.data.time",
        "self.data.ncon",
        "len(self.data.contact)",
        "self.data.contact.dist.sum()",
        "sum(one.dist for one in self.data.contact)",
        "self.data.geom('torso_geom').xpos[2]",
        "self.data.actuator_force[0]",
        "self.data.ctrl.sum()",
        "self.model.nq",
        "self.model.body('torso').id",
        "self.model.body_mass.sum()",
        "self.model.opt.timestep",
        "self.dt",
        "self.frame_skip",
        "self.control_cost(action)",
        "self.healthy_reward",
        "self.is_healthy",
        "self.contact_cost",
        "self.contact_forces.sum()",
        "self.state_vector()[0]",
        "self.get_body_com('torso')[0]",
        "self._forward_reward_weight",
        "self._ctrl_cost_weight",
        "self._contact_cost_weight",
        "self._healthy_reward",
        "self._healthy_z_range[1]",
        "self._terminate_when_unhealthy",
        "self._main_body",
        "self._reset_noise_scale",
        "self.init_qpos[2]",
        "self.init_qvel.sum()",
        "self._get_obs().sum()",
        "self.action_space.high[0]",
        "self.observation_structure['qpos']",
        "self.np_random.uniform() < 1",
        "self.unwrapped.data.qpos[0]",
        "math.tanh(x_velocity)",
        "action @ action",
        "action.shape[0]",
    ],
)
def test_a_reward_can_read_what_the_official_class_offers(expression: str) -> None:
    assert np.isfinite(value_of(expression))


def test_what_it_reads_is_of_its_own_simulation_and_of_now() -> None:
    seen: list[tuple[Any, ...]] = []

    def reward(self: Any, x_velocity: float, action: Any) -> tuple[float, dict[str, float]]:
        forces = self.data.body("torso").xpos[2], self.data.cfrc_ext.sum()
        seen.append((*self.data.qpos, self.data.time, *forces, x_velocity, *action))
        return 0.0, {}

    batch = simulations("ant", 2, reward)
    batch.reset(0)
    random = np.random.default_rng(0)
    for _ in range(3):
        seen.clear()
        before = batch.data[1].body("torso").xpos[0].copy()
        actions = random.uniform(-1, 1, (2, 8))
        batch.step(actions)
        one = batch.data[1]
        speed = (one.body("torso").xpos[0] - before) / batch.environment.dt
        forces = one.body("torso").xpos[2], one.cfrc_ext.sum()
        assert seen[1] == (*one.qpos, one.time, *forces, speed, *actions[1])


@pytest.mark.parametrize("task", ["hopper", "half-cheetah"])
def test_forces_are_computed_for_robots_that_do_not_observe_them(task: str) -> None:
    look = "np.abs(self.data.cfrc_ext).sum() + np.abs(self.data.body(1).cacc).sum()"
    eager = run(f"return {look}, {{'force': {look}}}", task, steps=40)
    forces = eager.reward_statistics()["force"]
    assert forces.high > forces.low > 0.0
    # Looked at late, and through a view that was taken early.
    late = run(
        "if not hasattr(self, 'view'): self.view = self.data.body(1).cacc\n"
        "value = np.abs(self.view).sum()\n"
        "return value, {'acceleration': value}",
        task,
        steps=40,
    )
    seen = late.reward_statistics()["acceleration"]
    assert seen.high > seen.low > 0.0


@pytest.mark.parametrize(
    "attack",
    [
        "self.data.qpos[0] = 100.0",
        "self.data.qvel += 1.0",
        "self.data.qpos = np.zeros(15)",
        "self.data.body('torso').xpos[:] = 0",
        "self.data.time = 0",
        "self.model.opt.gravity[2] = 0",
        "self.model.opt.timestep = 0",
        "self.model.body_mass[:] = 0",
        "self.set_state(self.init_qpos, self.init_qvel)",
        "self.init_qpos[2] = 3",
        "self.reset_model()",
        "self.reset(seed=0)",
        "self.step(action)",
        "self.mujoco_renderer.data.qpos[0] = 100.0",
        "np.copyto(self.data.qvel, 9.0)",
        "self.data.xfrc_applied[:] = 9.0",
        "self.data.contact[0].dist = 1.0",
        "self.data.qvel.base[0] = 50.0",
        "self.data.qpos.base.fill(3.0)",
        "self.data.qvel.setflags(write=True)",
        "self.data.qvel.flags.writeable = True",
    ],
)
def test_a_reward_cannot_change_the_physics(attack: str) -> None:
    with pytest.raises(RewardFailed, match=r"\(line 2: "):
        run(attack + "\nreturn 0.0, {}")


def test_changing_its_action_or_an_official_attribute_stays_without_effect() -> None:
    plain = run("return 0.0, {}", steps=5)
    odd = run("action *= 0\nself.frame_skip = 50\nself._main_body = 3\nreturn 0.0, {}", steps=5)
    np.testing.assert_array_equal(odd.observation, plain.observation)
    assert odd.root_positions[0, 0] == plain.root_positions[0, 0]


@pytest.mark.parametrize(
    ("returned", "said"),
    [
        ("None", "None"),
        ("1.0", "float 1.0"),
        ("(1.0,)", "tuple (1.0,)"),
        ("(1.0, {}, {})", "tuple"),
        ("(None, {})", "None in the place of the number"),
        ("('1', {})", "str '1'"),
        ("(1j, {})", "object of type complex"),
        ("(np.zeros(3), {})", "array of shape (3,)"),
        ("(np.zeros(0), {})", "array of shape (0,)"),
        ("(10 ** 400, {})", "int"),
        ("(1.0, None)", "None in the place of the terms"),
        ("(1.0, [1.0])", "list [1.0]"),
        (
            "(float('nan'), {'a': 1.0})",
            "was nan; it must be finite; it returned the dict {'a': 1",
        ),
        ("(-np.inf, {})", "was -inf"),
        ("(np.array([np.nan]), {})", "was nan"),
    ],
)
def test_what_is_no_reward_is_refused_in_words(returned: str, said: str) -> None:
    with pytest.raises(RewardFailed) as failed:
        run(f"return {returned}")
    message = str(failed.value)
    assert said in message
    assert "qpos = [" in message and "x_velocity = " in message and "action = [" in message


@pytest.mark.parametrize(
    "returned",
    ["2", "True * 2", "np.float32(2)", "np.int64(2)", "np.array(2.0)", "np.array([[2.0]])"],
)
def test_what_is_one_number_is_accepted(returned: str) -> None:
    batch = run(f"return {returned}, {{'same': {returned}}}")
    assert batch.step(np.zeros((2, 8))).reward.tolist() == [2.0, 2.0]
    assert batch.reward_statistics()["same"].mean == 2.0


def test_an_exception_is_reported_with_its_line() -> None:
    with pytest.raises(RewardFailed) as failed:
        run("speed = x_velocity\nreturn self.data.qpos[99], {}", "swimmer")
    assert "IndexError" in str(failed.value)
    assert "(line 3: `return self.data.qpos[99], {}`)" in str(failed.value)
    with pytest.raises(RewardFailed, match="SystemExit"):
        run("raise SystemExit(0)", "swimmer")


def test_terms_that_are_no_numbers_are_left_out() -> None:
    batch = run(
        "return 1.0, {'good': x_velocity, 'text': 'a', 'none': None, 'nan': np.nan, 3: 4.0, "
        "'vector': np.zeros(2)}"
    )
    assert list(batch.reward_statistics()) == ["good"]


def test_statistics_are_those_of_all_steps_and_simulations() -> None:
    values: list[float] = []

    def reward(self: Any, x_velocity: float, action: Any) -> tuple[float, dict[str, float]]:
        values.append(float(x_velocity))
        return 0.0, {"speed": x_velocity}

    batch = simulations("swimmer", 3, reward)
    batch.reset(0)
    random = np.random.default_rng(0)
    for _ in range(10):
        batch.step(random.uniform(-1, 1, (3, 2)))
    speed = batch.reward_statistics()["speed"]
    assert len(values) == 30
    assert speed.mean == pytest.approx(np.mean(values), abs=1e-14)
    assert (speed.low, speed.high) == (min(values), max(values))


def test_names_made_up_in_every_step_do_not_pile_up() -> None:
    batch = run("return 0.0, {f'{self.data.time}{i}': 1.0 for i in range(20)}", steps=10)
    assert len(batch.reward_statistics()) == 64


def test_a_reward_keeps_state_per_simulation_until_the_episode_ends() -> None:
    task = get_task("hopper")
    counting = reward_function(
        HEADER
        + "    self.count = getattr(self, 'count', 0) + 1\n"
        + "    return float(self.count), {}\n"
    )
    batch = VectorEnv(task, task.reference, 2, counting)
    batch.reset(0)
    expected = np.zeros(2)
    random = np.random.default_rng(0)
    ended = 0
    for _ in range(150):
        done = batch.step(random.uniform(-1, 1, (2, 3)))
        expected += 1
        assert done.reward.tolist() == expected.tolist()
        expected[done.terminated] = 0
        ended += done.terminated.sum()
    assert ended > 1


@pytest.mark.parametrize("task", OFFICIAL)
def test_two_rewards_give_two_streams(task: str) -> None:
    def other(self: Any, x_velocity: float, action: Any) -> tuple[float, dict[str, float]]:
        return -x_velocity, {}

    streams = []
    for reward in (reference(task), other):
        batch = simulations(task, 2, reward)
        batch.reset(0)
        steps = [batch.step(np.full((2, batch.action_size), 0.3)) for _ in range(5)]
        streams.append([(one.observation, one.reward) for one in steps])
    for (seen, first), (same, second) in zip(*streams, strict=True):
        np.testing.assert_array_equal(seen, same)
        assert (first != second).all()
