"""Fine stage: alternate body and reward until a cycle improves neither (paper, Sec. 4.2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from robomore.designers.designer import Designer
from robomore.errors import ProposalFailed
from robomore.search.measure import Evaluate, improves
from robomore.search.propose import MapFn, independent, sequential_map
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
    map_fn: MapFn = sequential_map,
) -> list[Evaluation]:
    """Return each survivor's best after refinement, in the survivors' order (paper, Alg. 1).

    Branches advance side by side, one batch a half-cycle, and each sees the grid and its own
    trials only, so the result does not depend on how many run at once. A half-cycle for which the
    designer has no proposal improves nothing.

    Args:
        designer: improves bodies and rewards from the history it is shown.
        evaluate: measures a batch.
        survivors: what the branches start from.
        grid: all evaluations of the coarse stage, those that screening cut short among them.
        objective: `efficiency` or `fitness`.
        max_cycles: bound on the cycles of a branch.
        map_fn: asks for the proposals of the branches.
    """
    branches = [_Branch(index, best, list(grid)) for index, best in enumerate(survivors)]
    for cycle in range(1, max_cycles + 1):
        active = [branch for branch in branches if branch.improved]
        if not active:
            break
        for branch in active:
            branch.improved = False

        bodies = independent(
            [
                partial(
                    designer.improve_morphology,
                    Slot("fine", "morphology", branch.index, cycle),
                    branch.best,
                    tuple(branch.history),
                )
                for branch in active
            ],
            map_fn,
        )
        designs = [
            (branch, Design(body, branch.best.design.reward))
            for branch, body in zip(active, bodies, strict=True)
            if not isinstance(body, ProposalFailed)
        ]
        _advance(evaluate, designs, cycle, "morphology", objective)

        programs = independent(
            [
                partial(
                    designer.improve_reward,
                    Slot("fine", "reward", branch.index, cycle),
                    branch.best,
                    tuple(branch.history),
                )
                for branch in active
            ],
            map_fn,
        )
        designs = [
            (branch, Design(branch.best.design.morphology, program))
            for branch, program in zip(active, programs, strict=True)
            if not isinstance(program, ProposalFailed)
        ]
        _advance(evaluate, designs, cycle, "reward", objective)
    return [branch.best for branch in branches]


def _advance(
    evaluate: Evaluate,
    designs: Sequence[tuple[_Branch, Design]],
    cycle: int,
    changed: str,
    objective: str,
) -> None:
    """Measure the branches' proposals and keep what is better."""
    if not designs:
        return
    trials = [
        Trial(design, Place(stage="fine", branch=branch.index, cycle=cycle, changed=changed))
        for branch, design in designs
    ]
    for (branch, _), evaluation in zip(designs, evaluate(trials), strict=True):
        branch.history.append(evaluation)
        if improves(evaluation, branch.best, objective):
            branch.best = evaluation
            branch.improved = True
