"""What a reward keeps is of one simulation and survives a checkpoint, or the reward is refused."""

from __future__ import annotations

import gc
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from functools import cache
from pathlib import Path
from statistics import fmean
from typing import Any

import numpy as np
import pytest
from gymnasium.envs.mujoco.swimmer_v5 import SwimmerEnv
from keeping import (
    CONSTANTS,
    CONTENTS,
    HOLDERS,
    KEPT,
    LATE_KEPT,
    LATE_REFUSED,
    REFUSED,
    held,
)

from exhaustive import more_of
from robomore.envs.reward_imports import offered_modules
from robomore.envs.reward_runner import RewardRunner
from robomore.envs.robots.base import RobotEnvironment
from robomore.envs.vector_env import VectorEnv
from robomore.errors import InvalidReward, RewardFailed
from robomore.rewards.check import check_reward
from robomore.rewards.continuation import check_continuation
from robomore.rewards.load import load_reward
from robomore.tasks import get_task
from robomore.training.checkpoint import Checkpoint, load_checkpoint, save_checkpoint

TASK = get_task("swimmer")
STEPS, EPISODE = 40, 13
SHARED = {"steps of training"}
"""What all simulations see."""


@cache
def motion() -> tuple[VectorEnv, list[tuple[Any, ...]]]:
    """Return simulations, and (positions and velocities, x velocity, actions) of each step."""
    env = VectorEnv(TASK, TASK.reference, 2)
    env.reset(0)
    random, steps = np.random.default_rng(0), []
    for _ in range(STEPS):
        actions = random.uniform(-1, 1, (2, env.action_size))
        before = env.qpos[:, 0].copy()
        env.step(actions)
        steps.append((env.physics_state.copy(), (env.qpos[:, 0] - before) / 0.04, actions))
    return env, steps


class Replay:
    """Lets a reward judge the recorded motion."""

    def __init__(self, source: str, swapped: bool = False) -> None:
        env, self.steps = motion()
        self.data = env.data
        self.order = [1, 0] if swapped else [0, 1]
        self.generators = [np.random.default_rng(i) for i in self.order]
        program = load_reward(source)
        self.runner = RewardRunner(
            program, env.environment, self.data, self.generators, lambda place: None
        )

    def rewards(self, steps: Sequence[int]) -> list[list[float]]:
        given = []
        for step in steps:
            states, speeds, actions = (part[self.order] for part in self.steps[step])
            for data, state in zip(self.data, states, strict=True):
                data.qpos[:], data.qvel[:] = np.split(state, [len(data.qpos)])
            given.append(
                self.runner(speeds, actions, np.ones(2, np.bool_), np.zeros(2, np.bool_)).tolist()
            )
            if step % EPISODE == EPISODE - 1:
                self.runner.reset(0)
        return given


def continued(
    source: str, folder: Path | None = None, pauses: tuple[int, ...] = (5, 20), steps: int = STEPS
) -> tuple[list[list[float]], Replay]:
    """Return the rewards of a motion that is interrupted, through a checkpoint in `folder`."""
    replay, given = Replay(source), []
    for part in np.split(np.arange(steps), pauses):
        given += replay.rewards(part.tolist())
        state = replay.runner.state()
        states = [one.bit_generator.state for one in replay.generators]
        replay = Replay(source)
        for generator, words in zip(replay.generators, states, strict=True):
            generator.bit_generator.state = words
        if folder:
            save_checkpoint(folder, Checkpoint({}, {}, state))
            state = load_checkpoint(folder).environment  # type: ignore[union-attr]
        replay.runner.restore(state)
    return given, replay


@pytest.mark.parametrize("place", KEPT)
def test_what_is_kept_survives_a_checkpoint(place: str, tmp_path: Path) -> None:
    whole = Replay(KEPT[place])
    expected = whole.rewards(range(STEPS))
    given, last = continued(KEPT[place], tmp_path)
    assert np.ptp(expected) > 0
    assert given == expected
    assert last.runner.statistics() == whole.runner.statistics()
    for name, array in whole.runner.state().items():
        assert np.array_equal(array, last.runner.state()[name])


@pytest.mark.parametrize("place", sorted(KEPT.keys() - SHARED))
def test_what_is_kept_is_of_one_simulation(place: str) -> None:
    """Its neighbour and its order make no difference."""
    one = Replay(KEPT[place]).rewards(range(EPISODE - 1))
    other = Replay(KEPT[place], swapped=True).rewards(range(EPISODE - 1))
    assert one == [list(reversed(rewards)) for rewards in other]


@pytest.mark.parametrize("holder", more_of(HOLDERS, "self", "closure", "partial"))
def test_all_that_can_be_held_in_a_place_survives(holder: str) -> None:
    for content in CONTENTS:
        source = held(holder, content)
        expected = Replay(source).rewards(range(18))
        assert continued(source, pauses=(8,), steps=18)[0] == expected, content


@pytest.mark.parametrize("place", LATE_KEPT)
def test_what_is_kept_late_survives(place: str) -> None:
    expected = Replay(LATE_KEPT[place]).rewards(range(STEPS))
    assert continued(LATE_KEPT[place], pauses=(9, 35))[0] == expected


FLAGS = """
from enum import Flag
class E(Flag):
    A = 1
    B = 2
    {more}
n = [0]
def _get_rew(self, x_velocity, action):
    n[0] += 1
    self.way = E.A | E.B if n[0] > 10 else E.A
    return x_velocity + len(self.way), {{"forward": x_velocity}}
"""


@pytest.mark.parametrize(("more", "kept"), [("AB = 3", True), ("", False)])
def test_combinations_of_flags_have_names_or_are_refused(more: str, kept: bool) -> None:
    """Python adds one without a name to the class when it is first made."""
    reward = load_reward(FLAGS.format(more=more))
    said = pytest.raises(RewardFailed, match=r"changes `E`.*name each combination of members")
    with nullcontext() if kept else said:
        check_continuation(TASK, TASK.reference, reward)


@pytest.fixture
def untouched() -> Iterator[None]:
    """Take away what rewards have put on objects that everybody shares."""
    yield
    for shared in (offered_modules()["numpy"], np.mean, np.poly1d, Counter, RobotEnvironment):
        if "n" in vars(shared):
            del shared.n
    vars(fmean).clear()
    np.polynomial.Polynomial.domain[0] = -1.0
    for name in [name for name in SwimmerEnv.metadata if not isinstance(name, str)]:
        del SwimmerEnv.metadata[name]


@pytest.mark.usefixtures("untouched")
@pytest.mark.parametrize("said", LATE_REFUSED)
def test_what_is_changed_late_and_not_kept_is_refused_at_the_end(said: str) -> None:
    """With an interruption afterwards and without one."""
    whole = Replay(LATE_REFUSED[said])
    whole.rewards(range(STEPS))
    with pytest.raises(RewardFailed, match=re.escape(said)):
        whole.runner.state()
    if "`f`" not in said and "`R`" not in said:
        with pytest.raises(RewardFailed, match=re.escape(said)):
            whole.runner.check()


@pytest.mark.parametrize("place", ["list in a closure", "dataclass", "one list, two names"])
def test_the_check_lets_it_pass(place: str) -> None:
    check_continuation(TASK, TASK.reference, load_reward(KEPT[place]))


@pytest.mark.parametrize("place", REFUSED)
def test_what_cannot_be_kept_is_refused(place: str) -> None:
    source, said = REFUSED[place]
    # What a reward does to NumPy's settings ends with the outer `with`.
    with np.errstate():
        with pytest.raises((InvalidReward, RewardFailed)) as refused:
            check_continuation(TASK, TASK.reference, load_reward(source))
        gc.collect()
    assert said in str(refused.value)


def test_a_whole_simulation_goes_on_as_if_it_had_not_stopped() -> None:
    """With episodes that end on their own, and forces that are first looked at on the way."""
    task = get_task("hopper")
    source = KEPT["helper object in self"].replace(
        "    return v",
        "    if v > 0.5: k += self.data.cacc.sum() + self.data.subtree_linvel.sum()\n    return v",
    )
    actions = np.random.default_rng(0).uniform(-1, 1, (120, 2, 3))
    whole, paused = (VectorEnv(task, task.reference, 2, load_reward(source)) for _ in range(2))
    whole.reset(0)
    paused.reset(0)
    for step, one in enumerate(actions):
        expected, given = whole.step(one), paused.step(one)
        assert np.array_equal(expected.reward, given.reward)
        if step in (3, 60):
            saved = paused.state()
            paused = VectorEnv(task, task.reference, 2, load_reward(source))
            paused.restore(saved)


def test_no_reward_reaches_the_other_simulations() -> None:
    source = "def _get_rew(self, v, action):\n    return float(action.base is None), {}"
    assert Replay(source).rewards([0]) == [[1.0, 1.0]]


def test_what_is_usual_at_the_top_level_is_no_obstacle() -> None:
    assert check_reward(CONSTANTS) == []
    expected = Replay(CONSTANTS).rewards(range(STEPS))
    assert continued(CONSTANTS)[0] == expected
    check_continuation(TASK, TASK.reference, load_reward(CONSTANTS))
