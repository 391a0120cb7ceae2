"""A training run in miniature, so that a hundred hostile programs run in seconds.

`train` runs in the sandboxed process, as the real one does: it loads the reward, lets it judge a
robot that is a point on a line, and leaves a policy that is one number. `measure` runs in the
parent, on that number alone.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import msgspec
import numpy as np

from robomore.errors import RewardFailed
from robomore.rewards.load import load_reward
from robomore.sandbox.explain import explain
from robomore.sandbox.untrusted_files import read_file

POLICY = "policy.json"
CALLS = 60
"""Reward calls of one training."""
BEST = 1.0
"""No policy can be measured to be fitter than this."""


class Robot:
    """A point on a line that is pushed: what a reward may look at."""

    dt = 0.05
    healthy_reward = 1.0

    def __init__(self, seed: int) -> None:
        self.np_random = np.random.default_rng(seed)
        self.data = SimpleNamespace(qpos=np.zeros(3), qvel=np.zeros(3))
        self.model = SimpleNamespace(opt=SimpleNamespace(timestep=0.01))

    def push(self, force: float) -> float:
        """Return the velocity that `force` gives."""
        self.data.qvel[0] = force * (1.0 - 0.5 * force)
        self.data.qpos[0] += self.dt * self.data.qvel[0]
        return float(self.data.qvel[0])

    def control_cost(self, action: Any) -> float:
        return 0.01 * float(np.sum(np.square(action)))


class Policy(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What is left in the scratch folder."""

    force: float


class Claims(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What the sandboxed process says of its training."""

    steps: int
    terms: dict[str, float]


def train(payload: bytes, scratch: Path, report: Callable[[int], None]) -> bytes:
    """Try forces, keep the one that the reward likes best, leave it as `policy.json`."""
    reward = load_reward(json.loads(payload)["source"])
    robot = Robot(seed=1)
    best, liked = -math.inf, 0.0
    sums: dict[str, float] = {}
    for step in range(CALLS):
        force = (step % 21 - 10) / 10
        value, terms = _judge(reward, robot, robot.push(force), np.array([force]))
        if value > best:
            best, liked = value, force
        for name, term in terms.items():
            sums[name] = sums.get(name, 0.0) + term
        report(step)
    (scratch / POLICY).write_text(json.dumps({"force": liked}))
    return json.dumps({"steps": CALLS, "terms": sums}).encode()


def measure(scratch: Path) -> float:
    """Return the fitness of the policy in `scratch`, at most `BEST`.

    Raises:
        ValueError: there is no policy, or it is none.
    """
    policy = msgspec.json.decode(read_file(scratch / POLICY, 1_000), type=Policy)
    force = min(1.0, max(-1.0, policy.force))
    return 2.0 * force * (1.0 - 0.5 * force)


def _judge(
    reward: Any, robot: Robot, velocity: float, action: Any
) -> tuple[float, dict[str, float]]:
    try:
        result = reward(robot, velocity, action)
    except (Exception, SystemExit) as error:
        raise RewardFailed(f"The reward raised {explain(error)}.") from error
    if type(result) is not tuple or len(result) != 2 or not isinstance(result[1], Mapping):
        raise RewardFailed(f"The reward returned {type(result).__name__} and no pair.")
    value = result[0]
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.item()
    if not isinstance(value, int | float | np.number) or not math.isfinite(value):
        raise RewardFailed(f"The reward was no finite number but {str(value)[:100]}.")
    try:
        return float(value), {str(name): float(term) for name, term in result[1].items()}
    except (TypeError, ValueError) as error:
        raise RewardFailed(f"The reward has a term that is no number: {error}.") from error
