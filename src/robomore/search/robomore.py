"""RoboMoRe: coarse-to-fine optimisation of body and reward together (paper, Alg. 1)."""

from __future__ import annotations

from functools import partial

from robomore.designers.designer import Designer
from robomore.events import Observer, ignore
from robomore.search.coarse import coarse
from robomore.search.fine import fine
from robomore.search.measure import Evaluate, MeasureGrid, ranked, top
from robomore.search.propose import MapFn, sequential_map
from robomore.search.screening import screened
from robomore.settings import SearchSettings
from robomore.types import Evaluation, Reward, finished


def robomore(
    designer: Designer,
    evaluate: Evaluate,
    settings: SearchSettings,
    reference: Reward,
    observe: Observer = ignore,
    map_fn: MapFn = sequential_map,
) -> list[Evaluation]:
    """Return the refined designs, best first; the paper's answer is the first of them.

    Args:
        designer: proposes bodies and rewards.
        evaluate: trains and measures a batch of designs, RL(theta, r) in the paper.
        settings: N_M, N_R, k, the objective, bounds, and how the grid is screened.
        reference: reward that screening compares bodies under.
        observe: told whom screening cuts.
        map_fn: asks for proposals that do not depend on each other.

    Raises:
        NothingTrained: no pair of the grid could be trained, or none was proposed.
    """
    # Coarse: grid search with Diversity Reflection.
    measure: MeasureGrid = evaluate
    if settings.screening is not None:
        measure = partial(
            screened,
            evaluate,
            screening=settings.screening,
            reference=reference,
            objective=settings.objective,
            observe=observe,
        )
    grid = coarse(designer, measure, settings.morphologies, settings.rewards, map_fn)
    pairs = settings.morphologies * settings.rewards
    survivors = top(finished(grid), settings.survivors, settings.objective, pairs)

    # Fine: alternate between morphology and reward.
    refined = fine(
        *(designer, evaluate, survivors, grid),
        *(settings.objective, settings.max_cycles, map_fn),
    )
    return ranked(refined, settings.objective)
