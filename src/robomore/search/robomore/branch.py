"""A branch of the fine stage: its best design so far, and when a proposal is better than that.

By the paper's rule, a proposal is better if its one score is higher. Two trainings of the same
design differ too, often by more than two proposals do. So a close call can be measured again: both
designs are trained with a second seed, and the means are compared.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from statistics import fmean

from robomore.search.measure import improves
from robomore.search.robomore.turns import KINDS
from robomore.search.starts import Kind
from robomore.types import Evaluation

_ENOUGH = 2
"""Designs with two seeds from which a branch knows how far the seeds spread."""

REPEAT = 999_999
"""`Place.repeat` of a second training seed: none of the final's, which count from 1 up. The final
trains with seeds that no search has chosen by."""


@dataclass
class Branch:
    """One survivor on its way.

    Attributes:
        index: number of the branch.
        best: the best design so far, as it was measured first.
        history: all that the designer may see.
        close_call: relative difference of two scores up to which a call is close; 0 for the paper's
            rule.
        idle: cycles in a row that did not improve the best.
        failed: kinds of which a proposal was no better, since the best was found.
        again: the best with a second seed, once it was asked for.
        differences: relative differences between two seeds of the same design.
    """

    index: int
    best: Evaluation
    history: list[Evaluation]
    close_call: float = 0.0
    idle: int = 0
    failed: set[Kind] = field(default_factory=set)
    again: Evaluation | None = None
    differences: list[float] = field(default_factory=list)

    def ends(self, patience: int) -> bool:
        """Return whether nothing improves the best: idle for so long, and both kinds were tried."""
        return self.idle >= patience and len(self.failed) == len(KINDS)

    def is_close(self, new: Evaluation, objective: str) -> bool:
        """Return whether a second seed has to decide if `new` is better than the best."""
        score, best = new.score(objective), self.score(objective)
        if not self.close_call or score is None or best is None:
            return False
        return _relative(score, best) <= self.margin

    @property
    def margin(self) -> float:
        """Relative difference up to which a call is close: that between two seeds, once known."""
        if len(self.differences) < _ENOUGH:
            return self.close_call
        return math.sqrt(fmean(one**2 for one in self.differences))

    def score(self, objective: str) -> float | None:
        """Return the score of the best, as a mean over its seeds."""
        return _mean((self.best, self.again), objective)

    def note_seeds(self, first: Evaluation, second: Evaluation, objective: str) -> None:
        """Learn from two seeds of one design how far the seeds spread."""
        one, other = first.score(objective), second.score(objective)
        if one is not None and other is not None:
            self.differences.append(_relative(one, other))

    def consider(self, new: Evaluation, again: Evaluation | None, objective: str) -> None:
        """Take `new` as the best if it is better.

        Args:
            new: a proposal with the first seed.
            again: the same with a second seed, or `None` if the call was not close.
            objective: `efficiency` or `fitness`.
        """
        if again is None and self.again is None:
            better = improves(new, self.best, objective)
        elif again is None:
            score, best = new.score(objective), self.score(objective)
            better = score is not None and (best is None or score > best)
        else:
            better = _standing((new, again), objective) > _standing(
                (self.best, self.again), objective
            )
        if better:
            self.best, self.again, self.idle = new, again, 0
            self.failed.clear()


def _standing(seeds: tuple[Evaluation | None, ...], objective: str) -> tuple[int, float]:
    """Return what two designs are compared by: how many seeds trained, then the mean score."""
    count = sum(e is not None and e.score(objective) is not None for e in seeds)
    return count, _mean(seeds, objective) or 0.0


def _mean(seeds: tuple[Evaluation | None, ...], objective: str) -> float | None:
    scores = [score for e in seeds if e is not None and (score := e.score(objective)) is not None]
    return fmean(scores) if scores else None


def _relative(one: float, other: float) -> float:
    return abs(one - other) / max(abs(one), abs(other), 1e-12)
