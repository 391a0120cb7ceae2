"""What is sent to a worker and to the sandboxed process, and what comes back from them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from itertools import islice
from statistics import fmean

import msgspec

from robomore.store.schema import check_numbers
from robomore.text import one_line, to_json
from robomore.training.curve import check_curve
from robomore.training.policy import MLPPolicy
from robomore.types import Curve, Evaluation, Job, TermStatistics


@dataclass(frozen=True, slots=True)
class Request:
    """One evaluation to be done, and where.

    Attributes:
        job: what to do.
        key: of the evaluation.
        scratch: folder that training may write to, made and emptied by the worker. Empty for a
            worker that may share no disk with whoever asks: it makes one on its own disk.
        checkpoint: folder to continue from and to leave a checkpoint in; empty for none. Without a
            shared disk it is the name of a carried folder (`robomore.executors.carried`).
        containment: `strict` refuses to run without the operating system's layers.
        versions: of packages and of an own trainer's code, that the worker must have too.
        task: content of the job's task, if it comes from a file (`robomore.tasks.portable`).
    """

    job: Job
    key: str
    scratch: str
    checkpoint: str = ""
    containment: str = "strict"
    versions: dict[str, str] = field(default_factory=dict)
    task: bytes = b""


@dataclass(frozen=True, slots=True)
class Answer:
    """What comes back from a worker, which may share no disk with whoever asked.

    Attributes:
        evaluation: what training the design gave.
        policy: content of a policy file (`robomore.training.policy`); empty if there is none.
    """

    evaluation: Evaluation
    policy: bytes = b""


@dataclass(frozen=True, slots=True)
class Training:
    """What the sandboxed process says of its training. Untrusted code ran there, so no more than
    its type is believed.

    Attributes:
        steps: control steps done.
        terms: statistics of each reward term.
        notes: facts worth keeping.
        curve: how training went.
    """

    steps: int
    terms: dict[str, TermStatistics] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    curve: Curve | None = None


def checked_answer(reply: bytes, key: str, job: Job) -> Answer:
    """Return a worker's answer, so that whatever is kept of it can be kept and read again.

    Args:
        reply: what the worker sent.
        key: of the evaluation that it was asked for.
        job: likewise; it stands in the place of what the worker says of it.

    Raises:
        ValueError: it is no encoded `Answer`, or one that cannot be true or is too long to keep.
    """
    if not isinstance(reply, bytes):
        raise ValueError(f"it is of the type {type(reply).__name__} and not bytes")
    try:
        answer = msgspec.json.decode(reply, type=Answer)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None
    evaluation = answer.evaluation
    if evaluation.key != key:
        raise ValueError(f"it is for another job, {evaluation.key!r}")
    check_numbers(evaluation)
    _refuse_contradictions(evaluation)
    if evaluation.curve is not None:
        check_curve(evaluation.curve)
    evaluation = replace(evaluation, job=job, artifact="")
    size = len(to_json(replace(evaluation, curve=None))) - len(to_json(job))
    if size > _MOST_BYTES:
        raise ValueError(f"it has {size:,} bytes besides its policy (the most is {_MOST_BYTES:,})")
    if not evaluation.ok:
        return Answer(evaluation)
    MLPPolicy.from_bytes(answer.policy)
    return Answer(evaluation, answer.policy)


def _refuse_contradictions(evaluation: Evaluation) -> None:
    """Refuse numbers that do not follow from each other.

    Raises:
        ValueError: naming them.
    """
    fitness, volume, efficiency = evaluation.fitness, evaluation.volume, evaluation.efficiency
    if not evaluation.ok or fitness is None or not volume or efficiency is None:
        return
    if not math.isclose(efficiency, fitness / volume, rel_tol=1e-9, abs_tol=1e-9):
        raise ValueError(f"its efficiency {efficiency:g} is not {fitness:g} / {volume:g}")
    episodes = evaluation.episode_fitness
    if episodes and not math.isclose(fitness, fmean(episodes), rel_tol=1e-9, abs_tol=1e-9):
        raise ValueError(f"its fitness {fitness:g} is not the mean of its episodes")


def checked_training(reply: bytes) -> Training:
    """Return what a sandboxed process claims, cut to what fits a ledger and a page.

    Raises:
        ValueError: it is no encoded `Training`, or its learning curve breaks the bounds.
    """
    try:
        claimed = msgspec.json.decode(reply, type=Training)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None
    curve = claimed.curve
    if curve is not None:
        check_curve(curve)
        curve = Curve(curve.steps, {one_line(name): curve.series[name] for name in curve.series})
    terms = islice(claimed.terms.items(), _MOST_TERMS)
    return Training(
        claimed.steps,
        {one_line(name[:_LONGEST_NAME]): statistics for name, statistics in terms},
        tuple(one_line(note[:_LONGEST_NOTE]) for note in claimed.notes[:_MOST_NOTES]),
        curve,
    )


_MOST_BYTES = 2**20
"""Of an evaluation without its job and curve; usual ones have some thousand."""
_MOST_TERMS, _LONGEST_NAME = 64, 100
_MOST_NOTES, _LONGEST_NOTE = 16, 500
