"""Whether what a reward keeps grows with every call: seen by calling it a thousand times."""

from __future__ import annotations

import time

import numpy as np

from robomore.envs.reward_amount import Amount
from robomore.envs.vector_env import VectorEnv
from robomore.errors import RewardFailed
from robomore.rewards.dry_run_findings import Growth

CALLS = 500
"""Calls between two looks; a list that is cut at a length below it does not count as growing."""
_MOST_SECONDS = 2.0
_SHARE = 0.9
"""What grows by less than so many values a call is not told of."""


def amounts(env: VectorEnv) -> dict[str, Amount]:
    """Return how much the reward keeps for the first simulation, by name."""
    return env.reward_runner.amounts(0) if env.reward_runner is not None else {}


def marks(env: VectorEnv) -> dict[str, bytes]:
    """Return what the reward keeps for the training of the first simulation, as digests by name."""
    return env.reward_runner.marks(0) if env.reward_runner is not None else {}


def growth(env: VectorEnv, before: dict[str, Amount], episode_steps: int) -> dict[str, Growth]:
    """Return what grows with every call of the reward.

    The simulations stand still while it is called, but their time goes on. They cannot be used
    afterwards.

    Args:
        env: after some steps.
        before: amounts after half of these steps.
        episode_steps: of the task.
    """
    now, runner = amounts(env), env.reward_runner
    none = Amount()
    suspects = [name for name, held in now.items() if held.values > before.get(name, none).values]
    if not suspects or runner is None:
        return {}
    seen, seconds = [now], [0.0]
    speeds, actions = np.zeros(env.num_envs), np.zeros((env.num_envs, env.action_size))
    still = speeds, actions, env.healthy, np.zeros(env.num_envs, np.bool_)
    began = time.thread_time()
    try:
        for _ in range(2):
            started = time.thread_time()
            for _ in range(CALLS):
                for data in env.data:
                    data.time += float(env.environment.dt)
                runner(*still)
                if time.thread_time() - began > _MOST_SECONDS:
                    return {}  # So slow that it is told of anyway.
            seconds.append((time.thread_time() - started) / CALLS / env.num_envs)
            seen.append(amounts(env))
    except RewardFailed:
        return {}  # The same state twice is not what a reward has to expect.
    found = {}
    for name in suspects:
        if name in seen[1] and name in seen[2]:
            values = seen[2][name].values - seen[1][name].values
            size = seen[2][name].size - seen[1][name].size
            if values > _SHARE * CALLS:
                found[name] = Growth(
                    values / CALLS,
                    max(size, 0) / CALLS,
                    (seconds[1], seconds[2]),
                    episode_steps if name.startswith("self.") else 0,
                )
    return found
