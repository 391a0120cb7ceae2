"""Coarse stage: a grid of morphologies x rewards, made diverse by reflection (paper, Sec. 4.1)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TypeVar

from robomore.designers.designer import Designer
from robomore.identity import derive_seed
from robomore.search.measure import Evaluate
from robomore.search.method import SearchContext
from robomore.search.propose import diverse, filled, independent
from robomore.search.random import DEVIATION, drawn
from robomore.search.robomore.planning import COARSE
from robomore.search.robomore.screening import screened
from robomore.search.robomore.settings import RoboMoReSettings
from robomore.search.slim_reference import thinnest
from robomore.types import Design, Evaluation, Place, Slot, Trial

T = TypeVar("T")


def coarse(
    designer: Designer, evaluate: Evaluate, settings: RoboMoReSettings, context: SearchContext
) -> list[Evaluation]:
    """Return the evaluations of the pairs, row by row (paper, Alg. 1, first half).

    A slot that the designer cannot fill leaves its row or column empty. If the slim reference is
    in, it is the first row; if the reference reward is in, it is the first column.

    Raises:
        NothingTrained: there is not one morphology or not one reward.
    """

    def proposals(ask: Callable[[Slot, Sequence[T]], T], kind: str, count: int) -> list[T | None]:
        if not count:
            return []
        slots = [Slot(COARSE, kind, (index,)) for index in range(count)]
        if designer.reflects:
            found = diverse(ask, slots)
        else:
            found = independent([partial(ask, slot, ()) for slot in slots], context.map_fn)
        filled_slots = filled(found, kind)
        return [filled_slots.get(index) for index in range(count)]

    morphologies = proposals(
        designer.propose_morphology, "morphology", settings.proposed_morphologies
    )
    for row in range(settings.drawn_morphologies):
        seed = derive_seed(context.seed, COARSE, "gaussian", row)
        morphologies.append(drawn(context.task, seed, DEVIATION))
    # What a search was given to start from may stand in the grid anyway: its own line stays empty.
    if settings.slim_reference == "in":
        slim = thinnest(context.task)
        others = [m if m and m.parameters != slim.parameters else None for m in morphologies]
        morphologies = [slim, *others]
    rewards = proposals(designer.propose_reward, "reward", settings.proposed_rewards)
    if settings.reference_reward == "in":
        own = context.reference.reward
        rewards = [own, *(r if r and r.source != own.source else None for r in rewards)]
    trials = [
        Trial(Design(morphology, reward), Place(stage=COARSE, index=(i, j)))
        for i, morphology in enumerate(morphologies)
        for j, reward in enumerate(rewards)
        if morphology and reward
    ]
    if settings.screening == "none":
        return evaluate(trials)
    return screened(evaluate, trials, settings, context)
