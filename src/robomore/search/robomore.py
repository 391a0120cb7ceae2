"""RoboMoRe: coarse-to-fine optimisation of body and reward together (paper, Alg. 1)."""

from __future__ import annotations

from robomore.designers.designer import Designer
from robomore.search.coarse import coarse
from robomore.search.fine import fine
from robomore.search.measure import Evaluate, ranked, top
from robomore.settings import SearchSettings
from robomore.types import Evaluation


def robomore(designer: Designer, evaluate: Evaluate, settings: SearchSettings) -> list[Evaluation]:
    """Return the refined designs, best first; the paper's answer is the first of them.

    Args:
        designer: proposes bodies and rewards.
        evaluate: trains and measures a batch of designs, RL(theta, r) in the paper.
        settings: N_M, N_R, k, the objective, and bounds.

    Raises:
        NothingTrained: no pair of the grid could be trained.
    """
    # Coarse: grid search with Diversity Reflection.
    grid = coarse(designer, evaluate, settings.morphologies, settings.rewards)
    survivors = top(grid, settings.survivors, settings.objective)

    # Fine: alternate between morphology and reward.
    refined = fine(designer, evaluate, survivors, grid, settings.objective, settings.max_cycles)
    return ranked(refined, settings.objective)
