"""Coarse stage: a grid of morphologies x rewards, made diverse by reflection (paper, Sec. 4.1)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TypeVar

from robomore.designers.designer import Designer
from robomore.search.measure import MeasureGrid
from robomore.search.propose import MapFn, diverse, filled, independent, sequential_map
from robomore.types import Design, Evaluation, Place, Slot, Trial

T = TypeVar("T")


def coarse(
    designer: Designer,
    measure: MeasureGrid,
    morphologies: int,
    rewards: int,
    map_fn: MapFn = sequential_map,
) -> list[Evaluation]:
    """Return the evaluations of the pairs, row by row (paper, Alg. 1, first half).

    A slot that the designer cannot fill leaves its row or column empty.

    Args:
        designer: sees all earlier proposals each time (Diversity Reflection), or does without.
        measure: measures the pairs, or those that deserve it.
        morphologies: rows of the grid (N_M).
        rewards: columns of the grid (N_R).
        map_fn: asks for proposals that do not depend on each other.

    Raises:
        NothingTrained: not one body or not one reward was proposed.
    """

    def proposals(ask: Callable[[Slot, Sequence[T]], T], kind: str, count: int) -> dict[int, T]:
        slots = [Slot("coarse", kind, 0, index) for index in range(count)]
        if designer.reflects:
            found = diverse(ask, slots)
        else:
            found = independent([partial(ask, slot, ()) for slot in slots], map_fn)
        return filled(found, kind)

    bodies = proposals(designer.propose_morphology, "morphology", morphologies)
    programs = proposals(designer.propose_reward, "reward", rewards)
    return measure(
        [
            Trial(Design(body, program), Place(stage="coarse", morphology=i, reward=j))
            for i, body in bodies.items()
            for j, program in programs.items()
        ]
    )
