"""Which environments explore: all at first, then all but the deterministic ones."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from probes import SETTINGS

from robomore.testing.probe_env import ProbeEnv
from robomore.training.crossq import CrossQ
from robomore.training.exploration_noise import ExplorationNoise
from robomore.training.loop import TrainingRun, deterministic
from robomore.training.trainer import Transition


class Recording(ProbeEnv):
    """A probe that remembers what was done in it, and on what."""

    def __init__(self) -> None:
        super().__init__(length=1)
        self.seen: list[tuple[NDArray[Any], NDArray[Any]]] = []

    def step(self, actions: NDArray[np.floating[Any]]) -> Transition:
        self.seen.append((self._observation(), actions.copy()))
        return super().step(actions)


@pytest.mark.parametrize(("fraction", "count"), [(0.0, 0), (0.5, 2), (0.7, 2), (0.99, 3)])
def test_deterministic_environments_act_by_the_policy_itself_once_there_is_one(
    fraction: float, count: int
) -> None:
    settings = replace(SETTINGS, deterministic_env_fraction=fraction)
    environment = Recording()
    # What the compiled step does not read is set past its settings: compiling takes long.
    run = TrainingRun(CrossQ(SETTINGS), settings, environment, seed=3)
    while not run.updates:
        run.advance()
    for _, actions in environment.seen:
        # Draws of their own, none of them shared.
        assert len(np.unique(actions)) == environment.num_envs
    assert np.abs([actions for _, actions in environment.seen]).max() > 0.9

    policy = deterministic(run.layers)
    environment.seen.clear()
    run.advance()
    assert len(environment.seen) == settings.train_freq
    for observation, actions in environment.seen:
        exact = np.isclose(actions, policy.act(observation), atol=1e-6)[:, 0]
        assert exact[:count].all()
        assert not exact[count:].any()


class Chatty(ProbeEnv):
    """A probe whose observation ends in numbers that say nothing."""

    observation_size = 5

    def __init__(self) -> None:
        super().__init__()
        self.chatter = np.random.default_rng(9)

    def _observation(self) -> NDArray[np.float64]:
        said = super()._observation()
        return np.hstack([said, 100 * self.chatter.standard_normal((self.num_envs, 3))])


def test_networks_see_only_what_they_are_to_see_and_policies_take_all() -> None:
    settings = replace(SETTINGS, observed=2)
    runs = [
        TrainingRun(CrossQ(SETTINGS), settings, environment, seed=3)
        for environment in (ProbeEnv(), Chatty())
    ]
    for run in runs:
        while run.updates < 3 * SETTINGS.gradient_steps:
            run.advance()
    (*_, plain), (*_, chatty) = (run.policies() for run in runs)
    observation = Chatty().reset(4)
    assert observation.shape == (4, 5)
    np.testing.assert_array_equal(chatty.act(observation), plain.act(observation[:, :2]))
    # More than there is means all.
    wide = TrainingRun(CrossQ(SETTINGS), replace(SETTINGS, observed=90), ProbeEnv(), seed=3)
    wide.advance()
    assert wide.policies()[-1].act(observation[:, :2]).shape == (4, 1)


def test_noise_is_held_for_some_steps_and_then_drawn_anew() -> None:
    noise = ExplorationNoise(5, num_envs=300, action_size=2)
    random = np.random.default_rng(1)
    seen = np.array([noise.draw(random) for _ in range(200)])
    held = (seen[1:] == seen[:-1]).all(axis=2)
    # Environments change by themselves, each after 1 to 5 steps, mostly soon.
    runs = [len(run) + 1 for env in held.T for run in "".join(str(int(h)) for h in env).split("0")]
    assert max(runs) == 5
    lengths = np.bincount(runs)[1:6] / len(runs)
    assert (np.diff(lengths[:4]) < 0).all()
    assert lengths[0] == pytest.approx(1 / (np.pi**2 / 6), abs=0.03)
    assert seen.mean() == pytest.approx(0, abs=0.05)
    assert seen.std() == pytest.approx(1, abs=0.05)
    fresh = ExplorationNoise(1, num_envs=3, action_size=2)
    drawn = [fresh.draw(np.random.default_rng(2)) for _ in range(2)]
    np.testing.assert_array_equal(drawn[0], drawn[1])
