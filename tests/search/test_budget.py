"""A budget of control steps holds any method, and what is left of it is the best so far."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from robomore.search.budget import BudgetedEvaluate, BudgetSpent
from robomore.settings import Budget
from robomore.types import Design, Evaluation, Morphology, Place, Reward, Trial
from search.fakes import (
    STEPS,
    CountingDesigner,
    Measuring,
    context,
    evaluation,
    robomore,
    sizes,
)


def trial(morphology: float, repeat: int = 0) -> Trial:
    design = Design(Morphology((morphology,)), Reward("1"))
    return Trial(design, Place(stage="any", repeat=repeat))


def budgeted(steps: int | None) -> tuple[BudgetedEvaluate, Measuring]:
    measuring = Measuring(lambda morphology, reward: morphology)
    return BudgetedEvaluate(measuring, Budget(STEPS), steps), measuring


def test_the_trials_that_it_pays_for_are_measured_in_their_order() -> None:
    evaluate, measuring = budgeted(2 * STEPS + 1)
    with pytest.raises(BudgetSpent):
        evaluate([trial(1), trial(3), trial(2)])
    assert [e.efficiency for e in evaluate.best("efficiency")] == [3.0, 1.0]
    assert len(measuring.batches[0]) == 2 and evaluate.spent == 2 * STEPS


def test_the_same_training_is_paid_for_once_and_going_on_for_the_rest() -> None:
    evaluate, _ = budgeted(2 * STEPS)
    evaluate([trial(1), trial(2)], budget_fraction=0.2)
    evaluate([trial(1), trial(1)])
    assert evaluate.spent == 1.2 * STEPS
    evaluate([trial(1)])
    assert evaluate.spent == 1.2 * STEPS
    with pytest.raises(BudgetSpent):
        evaluate([trial(1, repeat=2)])


def test_a_design_stands_once_and_by_the_mean_of_its_seeds() -> None:
    lucky = {(2.0, 0): 9.0, (2.0, 1): 1.0}

    def measured(trials: Sequence[Trial], *, budget_fraction: float = 1.0) -> list[Evaluation]:
        return [
            evaluation(one.design, lucky.get((body, one.place.repeat), body))
            for one in trials
            for body in one.design.morphology.parameters
        ]

    evaluate = BudgetedEvaluate(measured, Budget(STEPS), None)
    evaluate([trial(2), trial(2, repeat=1), trial(6), trial(3)])
    best = evaluate.best("efficiency")
    assert [e.design.morphology.parameters[0] for e in best] == [6.0, 2.0, 3.0]


def test_without_a_budget_nothing_ends() -> None:
    evaluate, _ = budgeted(None)
    assert len(evaluate([trial(n) for n in range(50)])) == 50


@pytest.mark.parametrize("trainings", range(1, 14))
def test_the_paper_s_method_ends_at_any_point_with_the_best_so_far(trainings: int) -> None:
    def best(steps: int | None) -> tuple[list[float], int]:
        measuring = Measuring(lambda morphology, reward: morphology * reward)
        evaluate = BudgetedEvaluate(measuring, Budget(STEPS), steps)
        try:
            found = robomore(CountingDesigner(), evaluate, sizes(3, 2, survivors=0.3, max_cycles=2))
        except BudgetSpent:
            found = evaluate.best(context().objective)
        return [e.efficiency or 0.0 for e in found], evaluate.spent

    found, spent = best(trainings * STEPS)
    whole, needed = best(None)
    assert spent == min(trainings * STEPS, needed)
    if spent == needed:
        assert found == whole
    # A larger budget never finds less.
    assert trainings == 1 or found[0] >= best((trainings - 1) * STEPS)[0][0]
