"""Rewards as designers write them run for the whole batch, with the numbers of each simulation."""

from __future__ import annotations

from collections import Counter
from typing import Any

import pytest
from both_ways import BothWays, program

from robomore.designers.offline.reward_sampler import RewardSampler
from robomore.errors import ProposalFailed
from robomore.tasks import TASKS, get_task
from robomore.types import Reward, Slot

WHOLE = "the reward ran for the whole batch"
ROBOTS = ("ant", "half-cheetah", "hopper", "walker", "swimmer")

# In the manner of what language models write: names, order and habits, not any one text.
HABITS = {
    "weighted sum": (
        "forward_reward = self._forward_reward_weight * x_velocity\n"
        "ctrl_cost = self.control_cost(action)\n"
        "lateral = -0.5 * np.abs(self.data.qvel[1])\n"
        "total = forward_reward - ctrl_cost + lateral\n"
        "return total, {'forward': forward_reward, 'ctrl': -ctrl_cost, 'lateral': lateral}"
    ),
    "exponential": (
        "target = 1.5\nerror = abs(x_velocity - target)\nspeed = np.exp(-error) + np.exp(0.3 * "
        "x_velocity) - 1\nsmooth = -np.sum(np.abs(np.diff(action)))\n"
        "return speed + 0.1 * smooth, {'speed': speed, 'smooth': smooth}"
    ),
    "state with hasattr": (
        "if not hasattr(self, 'prev_velocity'):\n    self.prev_velocity = x_velocity\n"
        "    self.prev_action = np.zeros_like(action)\n"
        "steadiness = np.exp(-np.abs(x_velocity - self.prev_velocity)) - 1\n"
        "change = np.linalg.norm(action - self.prev_action)\n"
        "self.prev_velocity = x_velocity\nself.prev_action = action.copy()\n"
        "return x_velocity + steadiness - 0.1 * change, {'steady': steadiness, 'change': change}"
    ),
    "symmetry": (
        "if len(action) % 2 == 0:\n    left, right = action[1::2], action[0::2]\n"
        "    symmetry = -np.sum(np.abs(left - right))\nelse:\n    symmetry = 0\n"
        "bonus = np.exp(symmetry) - 1\nreturn x_velocity + bonus, {'symmetry': bonus}"
    ),
    "efficiency": (
        "cost = self.control_cost(action)\nefficiency = x_velocity / (cost + 1e-5)\n"
        "reward = np.tanh(efficiency / 100.0) + float(x_velocity)\n"
        "return float(reward), {'efficiency': float(efficiency), 'cost': -cost}"
    ),
    "clipping and max": (
        "speed = min(max(x_velocity, -1.0), 3.0)\nspin = np.clip(self.data.qvel[2] ** 2, 0, 10)\n"
        "gait = np.sum(np.sin(self.data.qpos[2:5]))\n"
        "return speed - 0.01 * spin + 0.05 * gait, {'speed': speed, 'spin': -spin, 'gait': gait}"
    ),
    "body position": (
        "height = self.data.body('torso').xpos[2]\n"
        "turned = self.data.body('torso').xmat.reshape(3, 3)[2, 2]\n"
        "centre = self.data.subtree_com[1][2]\n"
        "return np.exp(height - 1) + turned + centre, {'height': height, 'turned': turned}"
    ),
    "energy": (
        "n = self.model.nu\nrates = self.data.qvel[-n:]\npower = np.abs(action * rates)\n"
        "energy = math.sqrt(np.sum(power)) + np.mean(power ** 2) * self.dt\n"
        "return x_velocity - 0.01 * energy, {'energy': -energy}"
    ),
    "history": (
        "if not hasattr(self, '_speeds'):\n    self._speeds = []\n"
        "self._speeds.append(float(x_velocity))\nif len(self._speeds) > 3:\n"
        "    self._speeds.pop(0)\nmean = sum(self._speeds) / len(self._speeds)\n"
        "spread = np.std(self._speeds)\nreturn mean - spread, {'mean': mean, 'spread': -spread}"
    ),
    "rhythm": (
        "self.t = getattr(self, 't', 0) + 1\nphase = 2 * np.pi * 1.5 * self.t * self.dt\n"
        "wanted = np.array([np.sin(phase + i) for i in range(len(action))])\n"
        "rhythm = -np.mean((action - wanted) ** 2)\nreturn rhythm + x_velocity, {'rhythm': rhythm}"
    ),
    "helper function": (
        "def near(value, target, width):\n    return np.exp(-((value - target) / width) ** 2)\n"
        "pace = near(x_velocity, 2.0, 1.0)\nlevel = near(self.data.qvel[1], 0.0, 0.5)\n"
        "terms = {'pace': pace, 'level': level}\nreturn sum(terms.values()), terms"
    ),
    "loop over joints": (
        "penalty = 0.0\nfor i in range(self.model.nu):\n"
        "    penalty += 0.1 * np.abs(action[i]) * np.maximum(0, abs(action[i]) - 0.5)\n"
        "worst = max(abs(a) for a in action)\n"
        "return x_velocity - penalty - 0.1 * worst, {'penalty': -penalty, 'worst': worst}"
    ),
    "guarded": (
        "reward = np.log1p(np.abs(x_velocity)) * np.sign(x_velocity)\n"
        "if not np.isfinite(reward):\n    reward = 0.0\n"
        "if np.any(np.isnan(self.state_vector())):\n    return -10.0, {}\n"
        "return reward, {'progress': reward}"
    ),
}


@pytest.fixture(scope="module")
def robots() -> dict[str, BothWays]:
    return {}


def at_once(robots: dict[str, BothWays], task: str, source: str, **options: Any) -> str:
    """Assert that both ways agree; returns how the reward ran."""
    if task not in robots:
        robots[task] = BothWays(task)
    return robots[task].run(source, **options).note


@pytest.mark.parametrize("task", TASKS)
def test_reference_rewards(task: str, robots: dict[str, BothWays]) -> None:
    assert at_once(robots, task, get_task(task).reward, steps=40) == WHOLE


@pytest.mark.parametrize("habit", HABITS)
def test_rewards_in_the_manner_of_language_models(habit: str, robots: dict[str, BothWays]) -> None:
    for task in ROBOTS:
        assert at_once(robots, task, program(HABITS[habit])) == WHOLE, task


def test_health_in_conditions(robots: dict[str, BothWays]) -> None:
    """Simulations that have fallen are parted from the others."""
    body = (
        "alive = 1.0 if self.is_healthy else -5.0\n"
        "bonus = self.healthy_reward * float(self.is_healthy)\n"
        "return alive + bonus, {'alive': alive, 'bonus': bonus}"
    )
    for task in ("hopper", "walker", "ant"):
        assert at_once(robots, task, program(body), steps=60).startswith(WHOLE), task


@pytest.mark.parametrize("task", [*ROBOTS, "ant-jump"])
def test_rewards_of_the_offline_designer(task: str, robots: dict[str, BothWays]) -> None:
    composer = RewardSampler(get_task(task), seed=0)
    earlier: list[Reward] = []
    ways: Counter[str] = Counter()
    for index in range(12):
        try:
            earlier.append(composer.propose(Slot("coarse", "reward", 0, index), earlier))
        except ProposalFailed:
            break
        ways[at_once(robots, task, earlier[-1].source, steps=6)] += 1
    assert sum(ways.values()) >= 10
    assert set(ways) == {WHOLE}
