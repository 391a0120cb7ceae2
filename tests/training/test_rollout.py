"""Episodes of a policy on an environment whose every number is known."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from robomore.training.policy import MLPPolicy
from robomore.training.rollout import rollout
from robomore.training.trainer import Transition


class FallingEnv:
    """A robot that moves by its action each step and falls after as many steps as its seed says.

    Seeds of 10 and more end by time after 10 steps. The torso is `seed` high in the first step.
    """

    observation_size = 1

    def __init__(self, n: int) -> None:
        self.num_envs = n
        self.seed = np.zeros(n, np.int64)
        self.elapsed = np.zeros(n, np.int64)
        self.x = np.zeros(n)
        self.started: list[int] = []
        self.ended = np.ones(n, np.bool_)

    @property
    def root_positions(self) -> NDArray[np.float64]:
        return np.stack([self.x, self.seed - self.elapsed], axis=1).astype(float)

    def reset_one(self, index: int, seed: int) -> NDArray[np.float64]:
        self.started.append(seed)
        self.seed[index], self.elapsed[index], self.x[index] = seed, 0, 100.0 * seed
        self.ended[index] = False
        return np.array([1.0])

    def step(self, actions: NDArray[np.floating[Any]]) -> Transition:
        assert actions.shape == (self.num_envs, 1)
        assert not self.ended.any()
        self.elapsed += 1
        self.x += actions[:, 0]
        terminated = self.elapsed == self.seed
        truncated = self.elapsed == 10
        self.ended = terminated | truncated
        observation = np.ones((self.num_envs, 1))
        return Transition(observation, np.zeros(self.num_envs), terminated, truncated, observation)


POLICY = MLPPolicy((np.full((1, 1), 0.5, np.float32),), (np.zeros(1, np.float32),))
STEP = np.tanh(0.5)


@pytest.mark.parametrize("n", [1, 3, 8])
def test_each_seed_has_one_episode_whatever_runs_beside_it(n: int) -> None:
    seeds = [4, 12, 2, 7, 3]
    found = rollout(POLICY, FallingEnv(n), seeds)
    length = np.array([4, 10, 2, 7, 3])
    assert found.length.tolist() == length.tolist()
    assert found.fell.tolist() == [True, False, True, True, True]
    assert found.rest_height.tolist() == seeds
    assert found.lowest.tolist() == (np.array(seeds) - length).tolist()
    assert found.effort == pytest.approx(np.full(5, STEP))
    assert found.jerk == pytest.approx(np.zeros(5))


def test_seeds_are_used_in_order() -> None:
    environment = FallingEnv(2)
    rollout(POLICY, environment, [4, 12, 2, 7])
    assert environment.started[:4] == [4, 12, 2, 7]


def test_changes_of_action_are_measured() -> None:
    class Swinging(FallingEnv):
        def step(self, actions: NDArray[np.floating[Any]]) -> Transition:
            transition = super().step(actions)
            transition.observation = np.where(self.elapsed % 2, -1.0, 1.0)[:, None]
            return transition

    found = rollout(POLICY, Swinging(1), [4])
    assert found.jerk == pytest.approx([2 * STEP])
    assert found.effort == pytest.approx([STEP])
