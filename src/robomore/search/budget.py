"""A budget of control steps that any method is held to, counted alike for all of them."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import fmean

from robomore.search.measure import Evaluate, content, distinct, ranked
from robomore.settings import Budget
from robomore.types import Evaluation, Trial, finished


class BudgetSpent(Exception):
    """The budget does not pay for the next trial; everything paid for was measured before."""


class BudgetedEvaluate:
    """An `Evaluate` that ends the search, from inside, once its control steps are spent.

    What counts is what was asked for, known or not, so a run that is resumed spends the same. A
    design that is asked for twice is paid for once, and one whose training goes on pays for the
    rest. A failed training pays in full: how far it came is not known beforehand.

    Attributes:
        steps: budget, in control steps of training; `None` for no bound.
        spent: control steps so far.
    """

    def __init__(self, evaluate: Evaluate, candidate: Budget, steps: int | None) -> None:
        self.steps = steps
        self.spent = 0
        self._evaluate = evaluate
        self._candidate = candidate
        self._paid: dict[tuple[object, ...], int] = {}
        self._measured: dict[tuple[object, ...], Evaluation] = {}

    def __call__(
        self, trials: Sequence[Trial], *, budget_fraction: float = 1.0
    ) -> list[Evaluation]:
        """Measure the trials that the budget pays for, in their order.

        Raises:
            BudgetSpent: it does not pay for all of them.
        """
        affordable = []
        for trial in trials:
            cost = self._cost(trial, budget_fraction)
            if self.steps is not None and self.spent + cost > self.steps:
                break
            self.spent += cost
            self._paid[_training(trial)] = self._paid.get(_training(trial), 0) + cost
            affordable.append(trial)
        measured = self._evaluate(affordable, budget_fraction=budget_fraction)
        for trial, evaluation in zip(affordable, measured, strict=True):
            self._measured[_training(trial)] = evaluation
        if len(affordable) < len(trials):
            raise BudgetSpent
        return measured

    def best(self, objective: str) -> list[Evaluation]:
        """Return what was trained the longest, best first; each design once.

        One that was trained with several seeds stands by their mean.
        """
        found = ranked(finished(list(self._measured.values())), objective)
        scores: dict[object, list[float]] = {}
        for one in found:
            scores.setdefault(content(one.design), []).append(one.score(objective) or 0.0)
        return sorted(distinct(found), key=lambda one: -fmean(scores[content(one.design)]))

    def _cost(self, trial: Trial, budget_fraction: float) -> int:
        steps = round(budget_fraction * self._candidate.steps)
        return max(0, steps - self._paid.get(_training(trial), 0))


def _training(trial: Trial) -> tuple[object, ...]:
    return *content(trial.design), trial.place.repeat
