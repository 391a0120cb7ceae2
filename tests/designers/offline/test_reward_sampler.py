from __future__ import annotations

import ast
import math
from dataclasses import replace
from functools import cache
from itertools import combinations
from typing import Any

import gymnasium
import numpy as np
import pytest

from designers.evaluations import EACH_TASK
from robomore.designers.offline.designer import OfflineDesigner
from robomore.designers.offline.reward_composition import (
    STYLES,
    RewardComposition,
    guess_composition,
    middle,
    parse_composition,
)
from robomore.designers.offline.reward_sampler import RewardSampler, damped
from robomore.designers.offline.reward_terms import TERMS
from robomore.envs.reward_text import reward_function
from robomore.envs.vector_env import VectorEnv
from robomore.errors import ProposalFailed
from robomore.rewards.check import check_reward
from robomore.tasks.registry import TASKS
from robomore.types import Reward, Slot

COUNT = 25
OFFICIAL = {
    "hopper": "Hopper-v5",
    "half-cheetah": "HalfCheetah-v5",
    "swimmer": "Swimmer-v5",
    "walker": "Walker2d-v5",
}


def slot(index: int, attempt: int = 0) -> Slot:
    return Slot("coarse", "reward", (index,), attempt=attempt)


@cache
def sampler(task: str) -> RewardSampler:
    return RewardSampler(TASKS[task], seed=3)


@cache
def proposals(task: str) -> tuple[Reward, ...]:
    rewards: list[Reward] = []
    for index in range(COUNT):
        rewards.append(sampler(task).sample(slot(index), rewards))
    return tuple(rewards)


@cache
def official(task: str) -> Any:
    return gymnasium.make(OFFICIAL.get(task, "Ant-v5")).unwrapped


def checked(result: tuple[Any, dict[str, Any]]) -> float:
    """The sum, after a look at both parts of what a reward returned."""
    reward, terms = result
    assert math.isfinite(float(reward))
    assert float(reward) == pytest.approx(sum(float(term) for term in terms.values()))
    return float(reward)


@pytest.mark.parametrize("task", EACH_TASK)
def test_all_rewards_run_on_the_official_robot(task: str) -> None:
    environment = official(task)
    environment.reset(seed=0)
    random = np.random.default_rng(0)
    # Not only the proposals: every term that can be in one.
    alone = [
        RewardComposition({term.name: middle(term)}).source(sampler(task).robot)
        for term in sampler(task).suitable
        if term.sign > 0
    ]
    for source in [*(reward.source for reward in proposals(task)), *alone]:
        function = reward_function(source)
        for _ in range(3):
            action = random.uniform(-1, 1, environment.action_space.shape)
            environment.step(action)
            checked(function(environment, 0.7, action))


@pytest.mark.parametrize("task", EACH_TASK)
def test_all_rewards_run_in_training(task: str) -> None:
    known = TASKS[task]
    body = OfflineDesigner(known, 3).propose_morphology(Slot("coarse", "morphology", (0,)), ())
    for reward in proposals(task)[:8]:
        simulations = VectorEnv(known, body.parameters, 2, reward_function(reward.source))
        simulations.reset(0)
        for _ in range(3):
            step = simulations.step(np.full((2, simulations.action_size), 0.3))
            assert np.isfinite(step.reward).all()
        composition = parse_composition(reward.source, sampler(task).robot)
        assert composition is not None
        assert set(simulations.reward_statistics()) == set(composition.weights)


@pytest.mark.parametrize("task", EACH_TASK)
def test_rewards_differ_and_the_task_leads_each(task: str) -> None:
    rewards = proposals(task)
    assert len({reward.source for reward in rewards}) == COUNT
    compositions = [sampler(task).composition(reward.source) for reward in rewards]
    for reward, composition in zip(rewards, compositions, strict=True):
        assert [f for f in check_reward(reward.source) if f.severity == "error"] == []
        assert ast.get_docstring(ast.parse(reward.source).body[1])  # type: ignore[arg-type]
        assert reward.idea == composition.idea()
        assert composition.lead is not None
        standing = [t for t in composition.terms if t.part in ("survival", "bonus")]
        together = sum(composition.weights[term.name] for term in standing)
        assert together <= 1.05 * composition.weights[composition.lead.name]
    # The first five, the paper's number, share few terms.
    overlaps = [
        len(set(a.weights) & set(b.weights)) / len(set(a.weights) | set(b.weights))
        for a, b in combinations(compositions[:5], 2)
    ]
    assert np.mean(overlaps) < 0.25


def test_the_first_reward_is_a_plain_one() -> None:
    composition = sampler("hopper").composition(proposals("hopper")[0].source)
    assert list(composition.weights) == ["forward_speed", "alive", "effort"]


def test_each_task_has_terms_of_its_own() -> None:
    names = {task: {term.name for term in sampler(task).suitable} for task in TASKS}
    assert "travelling_wave" in names["swimmer"] and "travelling_wave" not in names["ant"]
    assert "diagonal_gait" in names["ant"] and "alternation" in names["walker"]
    assert "alive" in names["hopper"] and "alive" not in names["half-cheetah"]
    assert "rolling" in names["half-cheetah"] and "rolling" not in names["hopper"]
    # The desert's ground rises and falls, so height says nothing there.
    assert "riding_height" in names["ant"] and "riding_height" not in names["ant-desert"]
    # What asks for distance does not lead a jump.
    assert "forward_speed" not in names["ant-jump"] and "height_gain" in names["ant-jump"]
    for task, known in names.items():
        assert len(known) >= 12, task


def test_a_proposal_depends_on_its_arguments_alone() -> None:
    rewards = proposals("walker")
    fresh = RewardSampler(TASKS["walker"], seed=3)
    assert fresh.sample(slot(5), rewards[:5]) == rewards[5]
    assert fresh.sample(slot(1), rewards[:1]) == rewards[1]
    assert fresh.sample(slot(5, attempt=1), rewards[:5]) != rewards[5]
    assert fresh.sample(slot(0, attempt=1), ()) != rewards[0]


def test_costs_are_subtracted_and_speed_is_worth_something() -> None:
    environment = official("hopper")
    environment.reset(seed=0)
    still, hard = np.zeros(3), np.ones(3)
    for reward in proposals("hopper"):
        function = reward_function(reward.source)
        assert checked(function(environment, 2.0, still)) > checked(
            function(environment, 0.1, still)
        )
    source = RewardComposition({"forward_speed": 2.0, "effort": 0.1}).source(
        sampler("hopper").robot
    )
    function = reward_function(source)
    assert checked(function(environment, 1.0, hard)) == pytest.approx(2.0 - 0.3)
    assert function(environment, 1.0, hard)[1]["effort"] == pytest.approx(-0.3)


def test_motors_are_matched_with_their_joints() -> None:
    # The Ant's motors are in another order than its joints.
    environment = official("ant")
    environment.reset(seed=0)
    environment.data.qvel[:] = 0
    environment.data.qvel[12] = 2.0  # hip_4, the first motor's joint
    composition = RewardComposition({"forward_speed": 2.0, "power": 0.01})
    function = reward_function(composition.source(sampler("ant").robot))
    action = np.zeros(8)
    action[0] = 1.0
    assert function(environment, 0.0, action)[1]["power"] == pytest.approx(-0.02)


@pytest.mark.parametrize("style", STYLES)
def test_a_text_is_read_back_and_an_edited_one_is_not(style: str) -> None:
    robot = sampler("walker").robot
    composition = RewardComposition(
        {"sprint": 1.5, "alive": 0.5, "stride": 0.2, "power": 0.004}, style
    )
    source = composition.source(robot)
    assert parse_composition(source, robot) == composition
    assert parse_composition(source.replace("1.5 * x", "2.5 * x"), robot) is None
    assert parse_composition(source.replace("stride 0.2", "no_such_term 0.2"), robot) is None
    assert parse_composition("import numpy as np\n" + source, robot) is None
    # A composition of another robot's terms is not one of this robot's.
    assert parse_composition(source, sampler("swimmer").robot) is None


def test_the_terms_of_any_reward_are_guessed_by_its_words() -> None:
    suitable = sampler("ant").suitable
    ant = guess_composition(TASKS["ant"].reward, suitable)
    assert set(ant.weights) == {"forward_speed", "alive", "effort", "hard_contact"}
    nonsense = "def _get_rew(self, x_velocity, action):\n    return 0, {}\n"
    assert list(guess_composition(nonsense, suitable).weights) == ["forward_speed"]


def test_bonuses_for_standing_still_are_damped() -> None:
    weights = {"forward_speed": 1.0, "alive": 1.5, "upright": 0.5, "effort": 0.1}
    smaller = damped(RewardComposition(weights)).weights
    assert smaller["alive"] + smaller["upright"] == pytest.approx(1.0, rel=0.02)
    assert smaller["effort"] == 0.1


def test_no_term_of_a_reward_hides_another() -> None:
    composition = RewardComposition({"forward_speed": 1.0, "effort": 0.05})
    assert list(composition.with_term(TERMS["power"], 0.004).weights) == ["forward_speed", "power"]
    assert (
        composition.with_term(TERMS["effort"], 99.0).weights["effort"] == 2 * TERMS["effort"].high
    )


def test_a_robot_nothing_is_known_of_is_a_failed_proposal() -> None:
    strange = replace(TASKS["swimmer"], fitness="height")
    with pytest.raises(ProposalFailed, match="no reward term"):
        RewardSampler(strange, 0).sample(slot(0), ())
