"""A real evaluation whose trainer is quick: the robot, what the reward sees, what is left behind
and the measurement are the real ones."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from robomore.evaluation import train as real
from robomore.training.policy import MLPPolicy
from robomore.training.trainer import Progress, TrainingEnv, TrainingResult


class Quick:
    """Acts at random and keeps the action that was rewarded most."""

    def train(
        self,
        environment: TrainingEnv,
        steps: int,
        seed: int,
        checkpoint: Path | None = None,
        progress: Progress | None = None,
    ) -> TrainingResult:
        rng = np.random.default_rng(seed)
        environment.reset(seed)
        best, liked = -np.inf, np.zeros(environment.action_size)
        for step in range(steps // environment.num_envs):
            actions = rng.uniform(-1.0, 1.0, (environment.num_envs, environment.action_size))
            rewards = environment.step(actions).reward
            if rewards.max() > best:
                best, liked = float(rewards.max()), actions[rewards.argmax()]
            if progress is not None:
                progress(step)
        weights = np.zeros((environment.observation_size, environment.action_size), np.float32)
        return TrainingResult((MLPPolicy((weights,), (liked.astype(np.float32),)),))


def train(payload: bytes, scratch: Path, report: Callable[[int], None]) -> bytes:
    """Train as a real evaluation does, but quickly."""
    real.make_trainer = lambda settings: Quick()  # type: ignore[assignment]
    return real.train(payload, scratch, report)
