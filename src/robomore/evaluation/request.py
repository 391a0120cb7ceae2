"""What is sent to a worker and to the sandboxed process, and what comes back from them."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import islice

import msgspec

from robomore.sandbox.sanitize import sanitize
from robomore.training.curve import check_curve
from robomore.types import Curve, Evaluation, Job, TermStatistics


@dataclass(frozen=True, slots=True)
class Request:
    """One evaluation to be done, and where.

    Attributes:
        job: what to do.
        key: of the evaluation.
        scratch: folder that training may write to, made and emptied by the worker.
        checkpoint: folder to continue from and to leave a checkpoint in; empty for none.
        containment: `strict` refuses to run without the operating system's layers.
    """

    job: Job
    key: str
    scratch: str
    checkpoint: str = ""
    containment: str = "strict"


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


def believed(reply: bytes) -> Training:
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
        curve = Curve(curve.steps, {_one_line(name): curve.series[name] for name in curve.series})
    terms = islice(claimed.terms.items(), _MOST_TERMS)
    return Training(
        claimed.steps,
        {_one_line(name[:_LONGEST_NAME]): statistics for name, statistics in terms},
        tuple(sanitize(note[:_LONGEST_NOTE]) for note in claimed.notes[:_MOST_NOTES]),
        curve,
    )


def _one_line(name: str) -> str:
    """Return a name that starts no new line wherever it is shown."""
    return " ".join(sanitize(name).split())


_MOST_TERMS, _LONGEST_NAME = 64, 100
_MOST_NOTES, _LONGEST_NOTE = 16, 500
