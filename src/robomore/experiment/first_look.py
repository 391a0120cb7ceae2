"""Whether a search's first look at its designs comes after they have begun to learn."""

from __future__ import annotations

import math

from robomore.errors import InputError
from robomore.plan import Plan
from robomore.settings import RunSettings
from robomore.tasks import Task
from robomore.training.settings import least_steps
from robomore.training.tuned import resolve


def refuse_untrained(task: Task, settings: RunSettings, plan: Plan) -> None:
    """Refuse a search that would compare designs before any of them has learnt something.

    Raises:
        InputError: naming the stage, the steps and the remedy.
    """
    trainer, full = resolve(settings.trainer, task), settings.candidate.steps
    least = least_steps(trainer)
    for stage in plan.stages:
        if 0 < stage.shortest < least:
            # By the share that `shortest` was rounded from, at its smallest.
            enough = math.ceil(least * full / (stage.shortest - 0.5))
            raise InputError(
                f"the stage {stage.name} cuts designs after {stage.shortest} of {full} steps, and "
                f"trainer {trainer.name} has learnt nothing before {least}; give at least --steps "
                f"{enough}, let it learn sooner with --trainer-option learning_starts=NUMBER, or "
                "train all designs to the end (--method-option screening=none)"
            )
