"""Slots that stayed empty: no attempt gave a proposal that could be used, and the run went on."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from robomore.designers.recorded import ATTEMPTS
from robomore.settings import SearchSettings
from robomore.store.ledger import Proposal
from robomore.types import Place, Slot


@dataclass(frozen=True, slots=True)
class EmptySlot:
    """A slot that nobody could fill.

    Attributes:
        slot: where in the run, its attempt aside.
        reason: of the last attempt.
    """

    slot: Slot
    reason: str


def empty_slots(proposals: Iterable[Proposal]) -> tuple[EmptySlot, ...]:
    """Return the slots whose last attempt failed, in the order of the search."""
    last = [p for p in proposals if p.slot.attempt == ATTEMPTS - 1 and p.failure]
    found = [EmptySlot(replace(p.slot, attempt=0), p.failure) for p in last]
    return tuple(sorted(found, key=lambda empty: _rank(empty.slot)))


def pairs_without(empty: Sequence[EmptySlot], search: SearchSettings) -> dict[Place, str]:
    """Return the pairs of the grid that were never made for want of a body or a reward."""
    return {
        Place(stage="coarse", morphology=i, reward=j): f"no {one.slot.kind} was proposed"
        for one in empty
        if one.slot.stage == "coarse"
        for i in range(search.morphologies)
        for j in range(search.rewards)
        if (i if one.slot.kind == "morphology" else j) == one.slot.index
    }


def _rank(slot: Slot) -> tuple[int, int, int, int]:
    half = int(slot.kind == "reward")
    if slot.stage == "coarse":
        return 0, half, slot.index, 0
    return 1, slot.index, half, slot.branch
