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
