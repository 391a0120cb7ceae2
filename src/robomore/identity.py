"""Content keys and seeds: why parallel equals serial, and resumed equals uninterrupted."""

from __future__ import annotations

import hashlib
from typing import Any

from robomore.text import to_json
from robomore.types import Evaluation, Job


def content_key(*parts: Any) -> str:
    """Return 24 hex digits that depend on the content of `parts` and on nothing else.

    Args:
        parts: anything msgspec encodes (numbers, strings, lists, dicts, dataclasses).
    """
    canonical = to_json(parts, sort_keys=True)
    return hashlib.sha256(canonical).hexdigest()[:24]


def derive_seed(*parts: Any) -> int:
    """Return a seed in [0, 2^31) from the content of `parts`, never from order or time."""
    return int(content_key("seed", *parts), 16) % 2**31


def job_key(job: Job, versions: dict[str, str]) -> str:
    """Key of an evaluation: the job without its limits, and the versions that change its numbers.

    A one-line idea describes a design and does not change it, so it is no part of the key.
    """
    return content_key(*_training(job), job.steps, job.episodes, versions)


def training_key(job: Job, versions: dict[str, str]) -> str:
    """Key of a training run whatever its budget: what a checkpoint is continued under."""
    return content_key(*_training(job), versions)


def same_training(evaluation: Evaluation) -> object:
    """Return what evaluations share that are one training, stopped and continued."""
    design = evaluation.design
    return design.morphology.parameters, design.reward.source, evaluation.job.seed


def _training(job: Job) -> tuple[Any, ...]:
    design = (job.design.morphology.parameters, job.design.reward.source)
    trainer = (job.trainer.name, job.trainer.options)
    return job.task, job.task_key, design, trainer, job.seed
