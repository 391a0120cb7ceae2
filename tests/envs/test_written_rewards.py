"""Rewards as language models write them give what the Gymnasium environment gives.

There the reward is called with the environment itself as `self`; the vector environment calls it
with read-only copies, with health computed for all simulations at once, and in another order.
"""

from __future__ import annotations

import numpy as np
import pytest
from robots import OFFICIAL, ours

from robomore.envs.reward_text import reward_function
from robomore.envs.vector_env import VectorEnv
from robomore.tasks import get_task

HEADER = "from collections import deque\n\n\ndef _get_rew(self, x_velocity, action):\n"

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
    "efficiency": (
        "cost = self.control_cost(action)\nefficiency = x_velocity / (cost + 1e-5)\n"
        "reward = np.tanh(efficiency / 100.0) + float(x_velocity)\n"
        "return float(reward), {'efficiency': float(efficiency), 'cost': -cost}"
    ),
    "body position": (
        "height = self.data.body('torso').xpos[2]\n"
        "turned = self.data.body('torso').xmat.reshape(3, 3)[2, 2]\n"
        "centre = self.data.subtree_com[1][2]\n"
        "return np.exp(height - 1) + turned + centre, {'height': height, 'turned': turned}"
    ),
    "contacts": (
        "touching = 0\nfor i in range(self.data.ncon):\n"
        "    contact = self.data.contact[i]\n"
        "    touching += contact.dist < 0.01 and contact.geom1 != contact.geom2\n"
        "return x_velocity + 0.1 * touching, {'touching': touching}"
    ),
    "energy": (
        "n = self.model.nu\nrates = self.data.qvel[-n:]\npower = np.abs(action * rates)\n"
        "energy = math.sqrt(np.sum(power)) + np.mean(power ** 2) * self.dt\n"
        "return x_velocity - 0.01 * energy, {'energy': -energy}"
    ),
    "history": (
        "if not hasattr(self, '_speeds'):\n    self._speeds = deque(maxlen=3)\n"
        "self._speeds.append(float(x_velocity))\nmean = sum(self._speeds) / len(self._speeds)\n"
        "spread = np.std(self._speeds)\nreturn mean - spread, {'mean': mean, 'spread': -spread}"
    ),
    "rhythm": (
        "self.t = getattr(self, 't', 0) + 1\nphase = 2 * np.pi * 1.5 * self.t * self.dt\n"
        "wanted = np.array([np.sin(phase + i) for i in range(len(action))])\n"
        "rhythm = -np.mean((action - wanted) ** 2)\nreturn rhythm + x_velocity, {'rhythm': rhythm}"
    ),
    "random numbers": "noise = self.np_random.normal()\nreturn noise, {'noise': noise}",
    "guarded": (
        "reward = np.log1p(np.abs(x_velocity)) * np.sign(x_velocity)\n"
        "if not np.isfinite(reward):\n    reward = 0.0\n"
        "if np.any(np.isnan(self.state_vector())):\n    return -10.0, {}\n"
        "return reward, {'progress': reward}"
    ),
    "health": (
        "healthy = getattr(self, 'is_healthy', True)\nalive = 1.0 if healthy else -5.0\n"
        "bonus = getattr(self, 'healthy_reward', 0.0) * float(healthy)\n"
        "kind = 10.0 * (type(healthy) is bool)\n"
        "return alive + bonus + kind, {'alive': alive, 'bonus': bonus}"
    ),
    "contact cost": (
        "cost = getattr(self, 'contact_cost', 0.0)\nreturn x_velocity - cost, {'cost': -cost}"
    ),
}


ROBOTS = {"health": ("ant", "hopper", "walker"), "contacts": ("ant", "hopper")}
"""Robots on which a habit matters most; another one is tried on Ant and on one robot in turn."""

CASES = [
    pytest.param(
        task,
        habit,
        marks=()
        if task in ROBOTS.get(habit, ("ant", list(OFFICIAL)[number % len(OFFICIAL)]))
        else pytest.mark.exhaustive,
    )
    for number, habit in enumerate(HABITS)
    for task in OFFICIAL
]


@pytest.mark.parametrize(("task", "habit"), CASES)
def test_rewards_are_those_of_the_gymnasium_environment(task: str, habit: str) -> None:
    body = "".join(f"    {line}\n" for line in HABITS[habit].splitlines())
    reward = reward_function(HEADER + body)
    chosen = get_task(task)
    batch = VectorEnv(chosen, chosen.reference, 2, reward, auto_reset=False)
    alone = [ours(task, reward) for _ in range(2)]
    for seed, one in enumerate(alone):
        np.testing.assert_array_equal(batch.reset_one(seed, seed), one.reset(seed=seed)[0])
    going = np.ones(2, np.bool_)
    random = np.random.default_rng(0)
    for step in range(50):
        actions = random.uniform(-1, 1, (2, batch.action_size))
        together = batch.step(actions)
        for index in np.flatnonzero(going):
            _, value, terminated, _, _ = alone[index].step(actions[index])
            assert together.reward[index] == value, step
            assert together.terminated[index] == terminated
            going[index] = not terminated
