"""What the search knows of proposing: slots in, one proposal each out, or why there is none."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TypeVar

from robomore.errors import NothingTrained, ProposalFailed
from robomore.search.method import MapFn
from robomore.types import Slot

T = TypeVar("T")


def independent(asks: Sequence[Callable[[], T]], map_fn: MapFn) -> list[T | ProposalFailed]:
    """Return one proposal for each of `asks`, in order, or why the designer has none."""
    return map_fn([partial(_or_why_not, ask) for ask in asks])


def diverse(
    ask: Callable[[Slot, Sequence[T]], T], slots: Sequence[Slot]
) -> list[T | ProposalFailed]:
    """Return one proposal for each of `slots`, made with all earlier ones in view (paper, Sec. 4.1:
    Diversity Reflection); so one has to come after the other."""
    found: list[T | ProposalFailed] = []
    earlier: list[T] = []
    for slot in slots:
        proposal = _or_why_not(partial(ask, slot, tuple(earlier)))
        found.append(proposal)
        if not isinstance(proposal, ProposalFailed):
            earlier.append(proposal)
    return found


def filled(found: Sequence[T | ProposalFailed], kind: str) -> dict[int, T]:
    """Return the proposals that there are, by their number.

    Raises:
        NothingTrained: there is none.
    """
    proposals = {i: one for i, one in enumerate(found) if not isinstance(one, ProposalFailed)}
    if not proposals:
        why = next((f"; for example, {one}" for one in found), "")
        raise NothingTrained(
            f"nothing to train: the designer filled none of {len(found)} slots for a {kind}{why}; "
            "with a language model, `robomore llm check` tells what it answers, or try another one"
        )
    return proposals


def _or_why_not(ask: Callable[[], T]) -> T | ProposalFailed:
    try:
        return ask()
    except ProposalFailed as failure:
        return failure
