"""Slots that stayed empty: no attempt gave a proposal that could be used, and the run went on."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from robomore.designers.recorded import ATTEMPTS
from robomore.plan import Plan, Stage
from robomore.store.schema import Proposal
from robomore.types import Slot


@dataclass(frozen=True, slots=True)
class EmptySlot:
    """A slot that nobody could fill.

    Attributes:
        slot: where in the run, its attempt aside.
        reason: of the last attempt.
    """

    slot: Slot
    reason: str


def empty_slots(proposals: Iterable[Proposal], plan: Plan) -> tuple[EmptySlot, ...]:
    """Return the slots whose last attempt failed, in the order of the search."""
    names = [stage.name for stage in plan.stages]
    last = [p for p in proposals if p.slot.attempt == ATTEMPTS - 1 and p.failure]
    found = [EmptySlot(replace(p.slot, attempt=0), p.failure) for p in last]

    def rank(empty: EmptySlot) -> tuple[object, ...]:
        slot = empty.slot
        stage = names.index(slot.stage) if slot.stage in names else len(names)
        return stage, slot.index[-1:], slot.kind == "reward", slot.index

    return tuple(sorted(found, key=rank))


def lines_without(empty: Sequence[EmptySlot], axis: str, stage: Stage) -> dict[int, str]:
    """Return why rows or columns of a grid are missing, by their number.

    Args:
        empty: slots that nobody could fill.
        axis: `morphology` or `reward`.
        stage: that is a grid.
    """
    asked = sum(n for action, kind, n in stage.proposals if (action, kind) == ("propose", axis))
    # What nobody has to propose, such as the reference reward, comes first.
    first = stage.shape[stage.axes.index(axis)] - asked if asked and stage.shape else 0
    return {
        first + one.slot.index[0]: f"no {axis} was proposed: {one.reason}"
        for one in empty
        if one.slot.stage == stage.name and one.slot.kind == axis and not one.slot.improves
    }
