"""What the search knows of measuring: a batch of trials in, one evaluation each out."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Protocol

from robomore.errors import NothingTrained
from robomore.types import Design, Evaluation, Trial


class Evaluate(Protocol):
    """Measures a batch; answers in its order, one each. A bad design gives a failed evaluation."""

    def __call__(
        self, trials: Sequence[Trial], *, budget_fraction: float = 1.0
    ) -> list[Evaluation]:
        """Return evaluations after a fraction of the full training.

        Asked for more of it in the next batch, a training goes on from where it was. Asked later,
        it begins anew: the numbers are the same, but a budget counts what is new alone.
        """
        ...


def ranked(evaluations: Iterable[Evaluation], objective: str) -> list[Evaluation]:
    """Return the successful evaluations, best first; equals keep their order."""
    scored = [(score, e) for e in evaluations if (score := e.score(objective)) is not None]
    return [evaluation for _, evaluation in sorted(scored, key=lambda pair: -pair[0])]


def content(design: Design) -> tuple[tuple[float, ...], str]:
    """Return what two designs share that differ in their ideas alone."""
    return design.morphology.parameters, design.reward.source


def distinct(evaluations: Iterable[Evaluation]) -> list[Evaluation]:
    """Return the first evaluation of each design."""
    found: dict[object, Evaluation] = {}
    for one in evaluations:
        found.setdefault(content(one.design), one)
    return list(found.values())


def survivor_count(fraction: float, pairs: int) -> int:
    """Return how many of `pairs` are a fraction of them, at least one.

    5 % of 125 pairs is 6.25: rounding half up keeps the paper's six.
    """
    return max(1, math.floor(fraction * pairs + 0.5))


def top(
    evaluations: Sequence[Evaluation], fraction: float, objective: str, pairs: int = 0
) -> list[Evaluation]:
    """Return the best fraction of `evaluations`, at least one (paper, Alg. 1: Top(F, k)).

    Args:
        evaluations: of the same budget.
        fraction: to keep.
        objective: `efficiency` or `fitness`.
        pairs: what it is a fraction of, if that is more than `evaluations`.

    Raises:
        NothingTrained: all of them failed.
    """
    best = ranked(evaluations, objective)
    if not best:
        raise NothingTrained(_why_nothing(evaluations))
    return best[: survivor_count(fraction, max(pairs, len(evaluations)))]


def improves(new: Evaluation, old: Evaluation, objective: str) -> bool:
    """Return whether `new` is measured and better than `old`."""
    new_score, old_score = new.score(objective), old.score(objective)
    return new_score is not None and (old_score is None or new_score > old_score)


def _why_nothing(evaluations: Sequence[Evaluation]) -> str:
    counts = Counter(evaluation.status for evaluation in evaluations)
    if not counts:
        return "there was nothing to train: the designer proposed no design"
    (status, _), *_ = counts.most_common()
    example = next(e.diagnosis for e in evaluations if e.status is status)
    said = ", ".join(f"{count} {name}" for name, count in counts.most_common())
    return f"all {len(evaluations)} candidates failed ({said}); for example: {example}"
