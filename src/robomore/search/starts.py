"""Starting from what one has: given morphologies and rewards go into the pool of a search.

They take the first places where a method would propose something of that kind, and whatever comes
later builds on them as on any other proposal.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from robomore.errors import InputError
from robomore.plan import Plan
from robomore.types import Morphology, Reward, Start

Kind = Literal["morphology", "reward"]


def usable(
    starts: Sequence[Start],
    kinds: Sequence[Kind],
    plan: Plan,
    method: str,
    reference_first: bool = True,
) -> tuple[tuple[Morphology, ...], tuple[Reward, ...]]:
    """Return the morphologies and rewards of `starts` that a method takes, each of them once.

    Args:
        starts: what was given.
        kinds: what the method can start from.
        plan: of the method, which says how many first proposals it asks for.
        method: its name, for messages.
        reference_first: whether a method without a designer trains the reference before them.

    Raises:
        InputError: the method can use none of a start, or has fewer places than there are starts.
    """
    for start in starts:
        has = [kind for kind in ("morphology", "reward") if getattr(start, kind) is not None]
        if not set(has) & set(kinds):
            takes = (
                f"takes a {' or a '.join(kinds)}" if kinds else "starts from the reference alone"
            )
            raise InputError(
                f"{start.origin} is a {' and a '.join(has)}, and the method {method!r} {takes}; "
                "choose another --method, or leave --start-from out"
            )
    # What is given twice takes one place, and the designer fills the other.
    morphologies: dict[tuple[float, ...], Morphology] = {}
    rewards: dict[str, Reward] = {}
    for start in starts:
        if start.morphology and "morphology" in kinds:
            morphologies.setdefault(start.morphology.parameters, start.morphology)
        if start.reward and "reward" in kinds:
            rewards.setdefault(start.reward.source, start.reward)
    for kind, count in (("morphology", len(morphologies)), ("reward", len(rewards))):
        places = _places(plan, kind, reference_first)
        if count > places:
            raise InputError(
                f"{count} starts have a {kind}, and this search tries {places} first ones; "
                "give fewer, or a larger search (--preset, --method-option, --evaluations)"
            )
    return tuple(morphologies.values()), tuple(rewards.values())


def _places(plan: Plan, kind: str, reference_first: bool) -> int:
    """Return how many first proposals of a kind a plan has; without a designer, its evaluations."""
    proposed = [
        count
        for stage in plan.stages
        for purpose, what, count in stage.proposals
        if (purpose, what) == ("propose", kind)
    ]
    if any(stage.proposals for stage in plan.stages):
        return sum(proposed)
    return sum(stage.evaluations for stage in plan.stages) - reference_first
