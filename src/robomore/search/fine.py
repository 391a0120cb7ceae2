"""Fine stage: alternate body and reward until a cycle improves neither (paper, Sec. 4.2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from robomore.designers.designer import Designer
from robomore.search.measure import Evaluate, improves
from robomore.types import Design, Evaluation, Place, Slot, Trial


@dataclass
class _Branch:
    """One survivor on its way: its best so far, and what it has seen."""

    index: int
    best: Evaluation
    history: list[Evaluation]
    improved: bool = True


def fine(
    designer: Designer,
    evaluate: Evaluate,
    survivors: Sequence[Evaluation],
    grid: Sequence[Evaluation],
    objective: str,
    max_cycles: int,
) -> list[Evaluation]:
    """Return each survivor's best after refinement, in the survivors' order (paper, Alg. 1).

    Branches advance side by side, one batch a half-cycle, and each sees the grid and its own
    trials only, so the result does not depend on how many run at once.

    Args:
        designer: improves bodies and rewards from the history it is shown.
        evaluate: measures a batch.
        survivors: what the branches start from.
        grid: all evaluations of the coarse stage.
        objective: `efficiency` or `fitness`.
        max_cycles: bound on the cycles of a branch.
    """
    branches = [_Branch(index, best, list(grid)) for index, best in enumerate(survivors)]
    for cycle in range(1, max_cycles + 1):
        active = [branch for branch in branches if branch.improved]
        if not active:
            break
        for branch in active:
            branch.improved = False

        bodies = [
            designer.improve_morphology(
                Slot("fine", "morphology", branch.index, cycle), branch.best, branch.history
            )
            for branch in active
        ]
        designs = [
            Design(body, branch.best.design.reward)
            for branch, body in zip(active, bodies, strict=True)
        ]
        _advance(evaluate, active, designs, cycle, "morphology", objective)

        programs = [
            designer.improve_reward(
                Slot("fine", "reward", branch.index, cycle), branch.best, branch.history
            )
            for branch in active
        ]
        designs = [
            Design(branch.best.design.morphology, program)
            for branch, program in zip(active, programs, strict=True)
        ]
        _advance(evaluate, active, designs, cycle, "reward", objective)
    return [branch.best for branch in branches]


def _advance(
    evaluate: Evaluate,
    branches: Sequence[_Branch],
    designs: Sequence[Design],
    cycle: int,
    changed: str,
    objective: str,
) -> None:
    """Measure one proposal of each branch and keep what is better."""
    trials = [
        Trial(design, Place(stage="fine", branch=branch.index, cycle=cycle, changed=changed))
        for branch, design in zip(branches, designs, strict=True)
    ]
    for branch, evaluation in zip(branches, evaluate(trials), strict=True):
        branch.history.append(evaluation)
        if improves(evaluation, branch.best, objective):
            branch.best = evaluation
            branch.improved = True
