"""Many simulations at once: episodes, seeds, checkpoints, divergence."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from robots import OFFICIAL, ours, reference, simulations

from robomore.envs.reward_text import reward_function
from robomore.envs.vector_env import VectorEnv
from robomore.errors import RewardFailed, UnstableSimulation
from robomore.tasks import TASKS, get_task

STATEFUL = """
def _get_rew(self, x_velocity, action):
    self.speeds = [*getattr(self, "speeds", []), float(x_velocity)][-5:]
    if not hasattr(self, "last"):
        self.last = np.zeros(len(action))
    jerk = float(np.abs(action - self.last).sum())
    self.last = action
    return sum(self.speeds) - jerk + self.np_random.normal(), {"jerk": jerk}
"""


def drive(batch: VectorEnv, steps: int, seed: int) -> list[Any]:
    random = np.random.default_rng(seed)
    return [
        batch.step(random.uniform(-1, 1, (batch.num_envs, batch.action_size))) for _ in range(steps)
    ]


def same(first: list[Any], second: list[Any]) -> bool:
    names = ("observation", "reward", "terminated", "truncated", "final_observation")
    return all(
        np.array_equal(getattr(a, name), getattr(b, name))
        for a, b in zip(first, second, strict=True)
        for name in names
    )


@pytest.mark.parametrize("task", TASKS)
def test_sizes(task: str) -> None:
    batch = simulations(task, 3)
    first = batch.reset(0)
    step = batch.step(np.zeros((3, batch.action_size)))
    assert first.shape == step.observation.shape == (3, batch.observation_size)
    assert batch.observation_size == ours(task).observation_space.shape[0]
    assert step.reward.shape == step.terminated.shape == step.truncated.shape == (3,)
    assert step.observation.dtype == step.reward.dtype == first.dtype == np.float64
    assert step.terminated.dtype == step.truncated.dtype == np.bool_
    assert batch.root_positions.shape == (3, 2)


@pytest.mark.parametrize("task", OFFICIAL)
def test_same_seed_same_numbers_and_every_simulation_its_own(task: str) -> None:
    reward = reward_function(STATEFUL)
    batch, again = simulations(task, 3, reward), simulations(task, 3, reward)
    first = batch.reset(7)
    assert np.array_equal(first, again.reset(7))
    assert len(np.unique(first[:, 0])) == 3
    steps = drive(batch, 120, 1)
    assert same(steps, drive(again, 120, 1))
    assert not np.array_equal(batch.reset(8), first)
    assert np.array_equal(batch.reset(7), first)
    assert same(steps, drive(batch, 120, 1))


def test_a_simulation_does_not_depend_on_its_neighbours() -> None:
    few, many = simulations("hopper", 2), simulations("hopper", 5)
    assert np.array_equal(few.reset(0), many.reset(0)[:2])
    random = np.random.default_rng(0)
    for _ in range(100):
        actions = random.uniform(-1, 1, (5, 3))
        assert np.array_equal(few.step(actions[:2]).observation, many.step(actions).observation[:2])


def test_results_are_not_overwritten_by_later_steps() -> None:
    batch = simulations("swimmer", 2)
    first = batch.reset(0)
    before = first.copy()
    step = drive(batch, 1, 0)[0]
    kept = [step.observation.copy(), step.reward.copy(), batch.root_positions.copy()]
    places = batch.root_positions
    batch.reset_one(0, 1)
    batch.reset(1)
    drive(batch, 3, 1)
    assert np.array_equal(first, before)
    assert np.array_equal(step.observation, kept[0])
    assert np.array_equal(step.reward, kept[1])
    assert np.array_equal(places, kept[2])


def test_episodes_end_and_begin_by_themselves() -> None:
    batch = simulations("hopper", 4)
    batch.reset(0)
    height = 0
    for step in drive(batch, 200, 0):
        ended = step.terminated
        assert not step.truncated.any()
        going = ~ended
        assert np.array_equal(step.observation[going], step.final_observation[going])
        if ended.any():
            assert (step.observation[ended, height] > 1.2).all()  # standing again
            assert (step.observation[ended] != step.final_observation[ended]).any(axis=1).all()
    assert batch.elapsed.max() < 200


def test_episodes_are_cut_off_when_their_time_is_up() -> None:
    batch = simulations("swimmer", 2)
    batch.reset(0)
    *steps, last, after = drive(batch, 1001, 0)
    assert not any(step.truncated.any() or step.terminated.any() for step in steps)
    assert last.truncated.all() and not last.terminated.any()
    assert not np.array_equal(last.observation, last.final_observation)
    assert batch.elapsed.tolist() == [1, 1]
    assert not after.truncated.any()


def test_positions_are_those_of_the_episode_that_ended() -> None:
    """Fitness is read off them, so a reset must not come between."""
    batch, manual = simulations("hopper", 1), simulations("hopper", 1, auto_reset=False)
    start = manual.reset(3)
    assert np.array_equal(start, batch.reset(3))
    random = np.random.default_rng(0)
    terminated = False
    while not terminated:
        action = random.uniform(-1, 1, (1, 3))
        terminated = bool(manual.step(action).terminated[0])
        batch.step(action)
        assert np.array_equal(manual.root_positions, batch.root_positions)
        assert manual.root_positions[0, 0] == manual.data[0].qpos[0]
    assert batch.elapsed[0] == 0 < manual.elapsed[0]
    assert batch.data[0].qpos[0] != batch.root_positions[0, 0]
    first = manual.reset_one(0, 11)
    assert np.array_equal(first, ours("hopper").reset(seed=11)[0])
    assert manual.root_positions[0, 0] == manual.data[0].qpos[0]


def test_without_a_reward_all_rewards_are_zero() -> None:
    task = get_task("swimmer")
    bare = VectorEnv(task, task.reference, 2)
    bare.reset(0)
    paid = simulations("swimmer", 2)
    paid.reset(0)
    for one, other in zip(drive(bare, 20, 0), drive(paid, 20, 0), strict=True):
        assert not one.reward.any()
        assert np.array_equal(one.observation, other.observation)
    assert bare.reward_statistics() == {} and bare.notes() == ()


def test_actions_of_another_shape_are_refused() -> None:
    batch = simulations("swimmer", 2)
    batch.reset(0)
    with pytest.raises(ValueError, match=r"\(2,\), not \(2, 2\)"):
        batch.step(np.zeros(2))


@pytest.mark.parametrize("task", [*OFFICIAL, "ant-desert"])
def test_continues_to_the_last_bit(task: str) -> None:
    reward = reward_function(STATEFUL)
    batch = simulations(task, 3, reward)
    batch.reset(1)
    drive(batch, 37, 1)
    file = io.BytesIO()
    np.savez(file, **batch.state())
    rest = drive(batch, 60, 2)

    another = simulations(task, 3, reward)
    another.reset(99)
    drive(another, 5, 5)
    file.seek(0)
    with np.load(file, allow_pickle=False) as arrays:
        another.restore(dict(arrays))
    assert same(rest, drive(another, 60, 2))
    assert another.reward_statistics() == batch.reward_statistics()
    assert another.notes() == batch.notes()
    final, other = batch.state(), another.state()
    assert final.keys() == other.keys()
    assert all(np.array_equal(final[name], other[name]) for name in final)


def test_continues_in_the_same_object_without_a_reward() -> None:
    task = get_task("walker")
    batch = VectorEnv(task, task.reference, 2)
    batch.reset(0)
    drive(batch, 20, 0)
    state, observation = batch.state(), batch.observation.copy()
    rest = drive(batch, 60, 1)
    batch.restore(state)
    assert np.array_equal(batch.observation, observation)
    assert same(rest, drive(batch, 60, 1))


def test_what_cannot_be_written_down_fails_the_reward() -> None:
    text = "def _get_rew(self, v, a):\n    self.thing = iter([1])\n    return 0.0, {}\n"
    batch = simulations("swimmer", 1, reward_function(text))
    batch.reset(0)
    drive(batch, 1, 0)
    with pytest.raises(RewardFailed, match=r"self\.thing.*list_iterator"):
        batch.state()


@pytest.mark.parametrize("harm", [np.nan, 1e11])
def test_a_diverging_simulation_ends_its_episode(
    harm: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # MuJoCo writes its warnings to a file where it is run
    batch = simulations("half-cheetah", 2)
    batch.reset(0)
    drive(batch, 10, 0)
    batch.data[1].qvel[3] = harm
    (step,) = drive(batch, 1, 0)
    assert step.terminated.tolist() == [False, True]
    assert batch.diverged.tolist() == [False, True]
    for array in (step.observation, step.final_observation, step.reward):
        assert np.isfinite(array).all()
    assert batch.root_positions[1, 0] == 0.0  # a blow-up moves nothing forward
    assert batch.divergences == 1
    assert "diverged in 1 of 1" in batch.notes()[-1]
    assert not drive(batch, 1, 0)[0].terminated.any()


def test_a_blow_up_is_not_paid_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    task = get_task("half-cheetah")

    def mean_speed(self, x_velocity: float, action: object) -> tuple[float, dict[str, float]]:
        speed = self.data.qpos[0] / self.data.time + 1.0  # no number in the starting pose
        return speed, {"speed": speed}

    batch = VectorEnv(task, task.reference, 2, mean_speed)
    batch.reset(0)
    batch.data[1].qvel[0] = 1e12
    step = batch.step(np.zeros((2, batch.action_size)))
    assert batch.diverged.tolist() == [False, True]
    assert step.reward[0] > 0.5 and step.reward[1] == 0.0
    assert batch.reward_sums()["speed"][0] == 1


def test_what_is_stepped_after_its_episode_counts_no_more() -> None:
    batch = simulations("hopper", 1, auto_reset=False)
    batch.reset(0)
    batch.data[0].qpos[2] = 3.0  # fallen
    drive(batch, 5, 0)
    batch.reset_one(0, 1)
    batch.data[0].qvel[1] = np.nan
    drive(batch, 1, 0)
    assert "diverged in 1 of 2" in batch.notes()[-1]


def test_a_body_that_diverges_over_and_over_is_given_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    batch = simulations("half-cheetah", 1)
    batch.reset(0)
    with pytest.raises(UnstableSimulation, match="11 of 11 episodes"):
        for _ in range(20):
            batch.data[0].qvel[3] = np.nan
            drive(batch, 1, 0)


def test_the_reference_reward_tells_health_from_falling() -> None:
    batch = simulations("walker", 2, reference("walker"))
    batch.reset(0)
    drive(batch, 200, 0)
    healthy = batch.reward_statistics()["healthy"]
    assert (healthy.low, healthy.high) == (0.0, 1.0)
