"""Evaluations for tests of designers. Nothing is trained: the fitness is given or computed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pytest

from robomore.identity import content_key
from robomore.tasks.registry import TASKS
from robomore.tasks.task import Task
from robomore.tasks.unit_space import UnitSpace
from robomore.types import (
    Design,
    Evaluation,
    Job,
    Morphology,
    Reward,
    Status,
    TermStatistics,
    TrainerSettings,
)

EACH_TASK = [
    name
    if name in ("swimmer", "hopper", "ant-jump")
    else pytest.param(name, marks=pytest.mark.exhaustive)
    for name in TASKS
]
"""Task ids as test parameters: one task of each kind of robot by default."""

REWARD = Reward("def _get_rew(self, x_velocity, action):\n    return x_velocity, {}\n")


def evaluation(
    task: Task,
    morphology: Morphology,
    reward: Reward = REWARD,
    fitness: float = 1.0,
    status: Status = Status.OK,
    behaviour: Mapping[str, float] | None = None,
    terms: Mapping[str, TermStatistics] | None = None,
    diagnosis: str = "it did not go well",
) -> Evaluation:
    """Return an evaluation with `fitness`, or a failure with `diagnosis`."""
    job = Job(task.id, Design(morphology, reward), TrainerSettings(), 1000, 1, 0)
    key = content_key(morphology.parameters, reward.source)
    if status is not Status.OK:
        return Evaluation(key, job, status, diagnosis)
    volume = task.volume(morphology.parameters)
    return Evaluation(
        key,
        job,
        status,
        fitness=fitness,
        volume=volume,
        efficiency=fitness / volume,
        behaviour=dict(behaviour or {}),
        terms=dict(terms or {}),
    )


class Bowl:
    """Fitness that falls with the distance to one morphology in a task's unit cube."""

    def __init__(self, task: Task, summit: Sequence[float]) -> None:
        self.task = task
        self.space = UnitSpace(task)
        self.summit = self.space.units([summit])[0]

    def measure(self, morphology: Morphology, reward: Reward = REWARD) -> Evaluation:
        gap = self.space.units([morphology.parameters])[0] - self.summit
        fitness = 50 * float(np.exp(-16 * np.mean(gap**2)))
        return evaluation(self.task, morphology, reward, fitness)
