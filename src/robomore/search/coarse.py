"""Coarse stage: a grid of morphologies x rewards, made diverse by reflection (paper, Sec. 4.1)."""

from __future__ import annotations

from robomore.designers.designer import Designer
from robomore.search.measure import MeasureGrid
from robomore.types import Design, Evaluation, Morphology, Place, Reward, Slot, Trial


def coarse(
    designer: Designer, measure: MeasureGrid, morphologies: int, rewards: int
) -> list[Evaluation]:
    """Return the evaluations of the pairs, row by row (paper, Alg. 1, first half).

    Args:
        designer: sees all earlier proposals each time (Diversity Reflection).
        measure: measures the pairs, or those that deserve it.
        morphologies: rows of the grid (N_M).
        rewards: columns of the grid (N_R).
    """
    bodies: list[Morphology] = []
    for i in range(morphologies):
        bodies.append(designer.propose_morphology(Slot("coarse", "morphology", 0, i), bodies))

    programs: list[Reward] = []
    for j in range(rewards):
        programs.append(designer.propose_reward(Slot("coarse", "reward", 0, j), programs))

    return measure(
        [
            Trial(Design(body, program), Place(stage="coarse", morphology=i, reward=j))
            for i, body in enumerate(bodies)
            for j, program in enumerate(programs)
        ]
    )
