"""Fine stage: morphology and reward in turn until a cycle improves neither (paper, Sec. 4.2)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

from robomore.designers.designer import Designer
from robomore.errors import ProposalFailed
from robomore.search.measure import Evaluate, improves
from robomore.search.method import SearchContext
from robomore.search.propose import independent
from robomore.search.robomore.planning import FINE
from robomore.types import Design, Evaluation, Place, Slot, Trial

T = TypeVar("T")


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
    max_cycles: int,
    context: SearchContext,
) -> list[Evaluation]:
    """Return each survivor's best after refinement, in the survivors' order (paper, Alg. 1).

    Branches advance side by side, one batch a half-cycle, and each sees the grid and its own
    trials only, so the result does not depend on how many run at once. A half-cycle for which the
    designer has no proposal improves nothing.

    Args:
        designer: improves morphologies and rewards from the history it is shown.
        evaluate: measures a batch.
        survivors: what the branches start from.
        grid: all evaluations of the coarse stage, those that screening cut short among them.
        max_cycles: most cycles of a branch.
        context: the objective, and how proposals are asked for side by side.
    """
    branches = [_Branch(index, best, list(grid)) for index, best in enumerate(survivors)]
    for cycle in range(max_cycles):
        active = [branch for branch in branches if branch.improved]
        if not active:
            break
        for branch in active:
            branch.improved = False

        morphologies = _ask(designer.improve_morphology, "morphology", active, cycle, context)
        designs = [(b, Design(new, b.best.design.reward)) for b, new in morphologies]
        _advance(evaluate, designs, cycle, "morphology", context.objective)

        rewards = _ask(designer.improve_reward, "reward", active, cycle, context)
        designs = [(b, Design(b.best.design.morphology, new)) for b, new in rewards]
        _advance(evaluate, designs, cycle, "reward", context.objective)
    return [branch.best for branch in branches]


def _ask(
    improve: Callable[[Slot, Evaluation, Sequence[Evaluation]], T],
    kind: str,
    active: Sequence[_Branch],
    cycle: int,
    context: SearchContext,
) -> list[tuple[_Branch, T]]:
    """Return a proposal for each branch that the designer has one for."""
    asks = [
        partial(
            improve,
            Slot(FINE, kind, (branch.index, cycle), improves=True),
            branch.best,
            tuple(branch.history),
        )
        for branch in active
    ]
    answers = independent(asks, context.map_fn)
    return [
        (branch, answer)
        for branch, answer in zip(active, answers, strict=True)
        if not isinstance(answer, ProposalFailed)
    ]


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
        Trial(
            design,
            Place(stage=FINE, index=(branch.index, cycle), changed=changed, parent=branch.best.key),
        )
        for branch, design in designs
    ]
    for (branch, _), evaluation in zip(designs, evaluate(trials), strict=True):
        branch.history.append(evaluation)
        if improves(evaluation, branch.best, objective):
            branch.best = evaluation
            branch.improved = True
