"""An executor that trains nothing: evaluations at once, with numbers made from their keys.

Importing this module makes it known as `untrained`.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Sequence

import msgspec
import numpy as np

from robomore.evaluation.request import Answer, Request
from robomore.executors import EXECUTORS, Done, Outcome
from robomore.executors.executor import Progress, never
from robomore.report import page
from robomore.runs import Run
from robomore.tasks import get_task
from robomore.training.policy import MLPPolicy
from robomore.types import Curve, Evaluation, Status, TermStatistics

NO_POLICY = MLPPolicy((np.zeros((1, 1), np.float32),), (np.zeros(1, np.float32),))
"""Fits no robot: whatever moves it fails."""


class Untrained:
    """Stands in for `Processes` where a test is about proposals."""

    seconds = 0.0
    """That one evaluation takes."""

    def __init__(self, workers: int) -> None:
        self.workers = workers

    def map(
        self,
        function: str,
        payloads: Sequence[bytes],
        progress: Progress,
        timeout: float,
        should_stop: Callable[[], bool] = never,
    ) -> Generator[tuple[int, Outcome]]:
        for index, payload in enumerate(payloads):
            if should_stop():
                return
            progress(index, 0)
            time.sleep(self.seconds)
            request = msgspec.json.decode(payload, type=Request)
            yield index, Done(answer(request))

    def close(self) -> None:
        """Nothing to stop."""


def answer(request: Request) -> bytes:
    """Return what a worker would send."""
    return msgspec.json.encode(Answer(made_up(request), NO_POLICY.to_bytes()))


def made_up(request: Request) -> Evaluation:
    job = request.job
    volume = get_task(job.task).volume(job.design.morphology.parameters)
    fitness = int(request.key[:8], 16) / 16**8
    return Evaluation(
        request.key,
        job,
        Status.OK,
        fitness=fitness,
        volume=volume,
        efficiency=fitness / volume,
        behaviour={"forward_distance_m": fitness},
        terms={"speed": TermStatistics(fitness, 0.0, 1.0)},
        steps=job.steps,
        curve=Curve((job.steps // 2, job.steps), {"episode_return": (0.0, fitness)}),
    )


if "untrained" not in EXECUTORS:
    EXECUTORS.register("untrained", Untrained)
    recorded = page.recorded

    def moving(run: Run, key: str, name: str) -> bytes | None:
        """Leave out of a report what cannot move, which would be a warning each time."""
        nothing = run.load_policy(key).digest == NO_POLICY.digest
        return None if nothing else recorded(run, key, name)

    page.recorded = moving
