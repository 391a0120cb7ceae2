"""Fine stage: morphology and reward in turn until a cycle improves neither (paper, Sec. 4.2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from robomore.designers.designer import Designer
from robomore.errors import ProposalFailed
from robomore.search.measure import Evaluate
from robomore.search.method import SearchContext
from robomore.search.propose import independent
from robomore.search.robomore.branch import REPEAT, Branch
from robomore.search.robomore.planning import FINE
from robomore.search.robomore.turns import KINDS, Turns
from robomore.search.starts import Kind
from robomore.types import Design, Evaluation, Place, Slot, Trial


def fine(
    designer: Designer,
    evaluate: Evaluate,
    survivors: Sequence[Evaluation],
    grid: Sequence[Evaluation],
    max_cycles: int,
    patience: int,
    context: SearchContext,
    close_call: float = 0.0,
    turns: Turns | None = None,
) -> list[Evaluation]:
    """Return each survivor's best after refinement, best first (paper, Alg. 1).

    Branches advance side by side, one batch a half-cycle, and each sees the grid and its own
    trials only, so the result does not depend on how many run at once. A half-cycle for which the
    designer has no proposal improves nothing.

    Args:
        designer: improves morphologies and rewards from the history it is shown.
        evaluate: measures a batch.
        survivors: what the branches start from.
        grid: all evaluations of the coarse stage, those that screening cut short among them.
        max_cycles: most cycles of a branch.
        patience: cycles in a row without improvement after which a branch ends, if both kinds were
            tried on its best; 1 in the paper.
        context: the objective, and how proposals are asked for side by side.
        close_call: relative difference of two scores up to which a second seed decides; 0 decides
            by one seed, as the paper does.
        turns: whether the morphology or the reward is next; by default one after the other.
    """
    objective, turns = context.objective, turns or Turns()
    branches = [Branch(index, best, list(grid), close_call) for index, best in enumerate(survivors)]
    for cycle in range(max_cycles):
        active = [branch for branch in branches if not branch.ends(patience)]
        if not active:
            break
        for branch in active:
            branch.idle += 1

        for turn in range(len(KINDS) * cycle, len(KINDS) * (cycle + 1)):
            kind, index = turns.kind(turn), turns.index(turn)
            before = [branch.best for branch in active]
            designs = _ask(designer, kind, active, index, context)
            _advance(evaluate, designs, index, kind, objective)
            failed = [
                branch for branch, old in zip(active, before, strict=True) if branch.best is old
            ]
            for branch in failed:
                branch.failed.add(kind)
            turns.note(kind, 1 - len(failed) / len(active))
    branches.sort(key=lambda branch: -(branch.score(objective) or 0.0))
    return [branch.best for branch in branches]


def _ask(
    designer: Designer, kind: Kind, active: Sequence[Branch], index: int, context: SearchContext
) -> list[tuple[Branch, Design]]:
    """Return each branch's best with a new half, where the designer has a proposal for it."""

    def improved(branch: Branch) -> Design:
        slot = Slot(FINE, kind, (branch.index, index), improves=True)
        best, history = branch.best, tuple(branch.history)
        if kind == "morphology":
            return replace(best.design, morphology=designer.improve_morphology(slot, best, history))
        return replace(best.design, reward=designer.improve_reward(slot, best, history))

    answers = independent([partial(improved, branch) for branch in active], context.map_fn)
    return [
        (branch, answer)
        for branch, answer in zip(active, answers, strict=True)
        if not isinstance(answer, ProposalFailed)
    ]


def _advance(
    evaluate: Evaluate,
    designs: Sequence[tuple[Branch, Design]],
    index: int,
    changed: Kind,
    objective: str,
) -> None:
    """Measure the branches' proposals, close calls twice, and keep what is better."""
    if not designs:
        return
    trials = [
        Trial(
            design,
            Place(stage=FINE, index=(branch.index, index), changed=changed, parent=branch.best.key),
        )
        for branch, design in designs
    ]
    measured = evaluate(trials)
    for (branch, _), evaluation in zip(designs, measured, strict=True):
        branch.history.append(evaluation)
    close = [
        (branch, trial, evaluation)
        for (branch, _), trial, evaluation in zip(designs, trials, measured, strict=True)
        if branch.is_close(evaluation, objective)
    ]
    seconds = _with_second_seed(evaluate, close, objective)
    for (branch, _), evaluation in zip(designs, measured, strict=True):
        branch.consider(evaluation, seconds.get(branch.index), objective)


def _with_second_seed(
    evaluate: Evaluate, close: Sequence[tuple[Branch, Trial, Evaluation]], objective: str
) -> dict[int, Evaluation]:
    """Train close proposals, and the best that they are close to, with a second seed.

    Returns:
        The proposals' second evaluations by the number of their branch.
    """
    trials = [Trial(trial.design, replace(trial.place, repeat=REPEAT)) for _, trial, _ in close]
    waiting = [(branch, trial.place) for branch, trial, _ in close if branch.again is None]
    trials += [
        Trial(branch.best.design, replace(place, changed="", repeat=REPEAT))
        for branch, place in waiting
    ]
    if not trials:
        return {}
    measured = evaluate(trials)
    seconds = {}
    for (branch, _, first), second in zip(close, measured[: len(close)], strict=True):
        seconds[branch.index] = second
        branch.history.append(second)
        branch.note_seeds(first, second, objective)
    for (branch, _), second in zip(waiting, measured[len(close) :], strict=True):
        branch.again = second
        branch.history.append(second)
        branch.note_seeds(branch.best, second, objective)
    return seconds
