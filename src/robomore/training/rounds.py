"""Training in rounds: act for some steps, learn for some, until the budget is used up."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any, Protocol

from robomore.errors import InputError
from robomore.training.trainer import PROGRESS_SECONDS, Progress, TrainingEnv, TrainingResult


class Rounds(Protocol):
    """A training under way, which goes on one round at a time."""

    @property
    def steps(self) -> int:
        """Control steps done, over all environments."""
        ...

    def advance(self) -> None:
        """Do one round."""
        ...

    def result(self) -> TrainingResult:
        """Return what the training has given so far."""
        ...

    def save(self, folder: Path) -> None:
        """Leave a checkpoint in `folder`."""
        ...

    def restore(self, folder: Path, most_steps: int) -> None:
        """Continue from `folder` if it holds this training after at most `most_steps`."""
        ...


def whole_rounds(settings: Any, environment: TrainingEnv, steps: int) -> int:
    """Return `steps` control steps, rounded down to whole rounds.

    Args:
        settings: of an algorithm that learns every `train_freq` steps of each environment.
        environment: what it trains in.
        steps: the budget, over all environments.

    Raises:
        InputError: fewer steps than one round.
    """
    size = settings.train_freq * environment.num_envs  # which need not be `settings.num_envs`
    if steps < size:
        raise InputError(
            f"{steps} control steps are too few: one round of training is {size} "
            f"(train_freq = {settings.train_freq} times {environment.num_envs} environments)"
        )
    return int(steps // size * size)


def train_in_rounds(
    run: Rounds, steps: int, checkpoint: Path | None, progress: Progress | None
) -> TrainingResult:
    """Go on with `run` until `steps` control steps are done; see `Trainer.train`."""
    if checkpoint is not None:
        run.restore(checkpoint, steps)
    told = time.monotonic()
    while run.steps < steps:
        run.advance()
        if progress is not None and time.monotonic() - told > PROGRESS_SECONDS:
            told = time.monotonic()
            progress(run.steps)
    if progress is not None:
        progress(run.steps)
    if checkpoint is not None:
        run.save(checkpoint)
    return run.result()
