"""Runs a reward for the whole batch and once per simulation, on the same steps."""

from __future__ import annotations

from typing import Any

import numpy as np

from robomore.envs.batched.reward import BatchedReward
from robomore.envs.reward_runner import PerSimulationReward
from robomore.envs.reward_text import reward_function
from robomore.envs.vector_env import VectorEnv
from robomore.tasks import get_task

HEADER = "import math\nfrom collections import deque\nimport numpy as np\n\n\n"
SIGNATURE = "def _get_rew(self, x_velocity, action):\n"


def program(body: str, before: str = "") -> str:
    """A reward's text from the lines of its body."""
    return HEADER + before + SIGNATURE + "".join(f"    {line}\n" for line in body.splitlines())


class BothWays:
    """Simulations whose every step is rewarded twice, with some episodes that begin in between."""

    def __init__(self, task: str, n: int = 8) -> None:
        chosen = get_task(task)
        self.batch = VectorEnv(chosen, chosen.reference, n, auto_reset=False)
        self.n = n

    def run(self, source: str, steps: int = 14, seed: int = 0) -> BatchedReward:
        """Assert that both ways agree in every step; returns the runner for the whole batch."""
        batch, n = self.batch, self.n
        batch.reset(seed)
        live = {"qpos": batch.qpos, "qvel": batch.qvel, "cfrc_ext": batch.cfrc_ext}
        common: Any = (reward_function(source), batch.environment, batch.data)
        generators = [np.random.default_rng(i) for i in range(n)]
        whole = BatchedReward(*common, generators, batch._need_forces, live)
        single = PerSimulationReward(*common, generators, batch._need_forces)
        random = np.random.default_rng(seed)
        for step in range(steps):
            actions = random.uniform(-1, 1, (n, batch.action_size))
            batch.step(actions)
            x_velocity = batch.qvel[:, 0].copy()
            ours = whole(batch, x_velocity, actions.copy())
            theirs = single(batch, x_velocity, actions.copy())
            np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-12)
            if step % 5 == 3:
                for index in {step % n, (3 * step + 1) % n}:
                    batch.reset_one(index, step)
                    whole.reset(index)
                    single.reset(index)
        assert_same_statistics(whole.statistics(), single.statistics())
        return whole


def assert_same_statistics(ours: Any, theirs: Any) -> None:
    assert list(ours) == list(theirs)
    for name, term in theirs.items():
        for field in ("mean", "low", "high"):
            np.testing.assert_allclose(
                getattr(ours[name], field), getattr(term, field), rtol=1e-9, atol=1e-12
            )
