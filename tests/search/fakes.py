"""A designer and an evaluator that need no robot: one number is the morphology, one the reward."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from robomore.designers.designer import Designer
from robomore.events import Observer, ignore
from robomore.identity import content_key
from robomore.search import SearchContext
from robomore.search.measure import Evaluate
from robomore.search.method import MapFn, sequential_map
from robomore.search.robomore import RoboMoRe, RoboMoReSettings
from robomore.settings import Budget
from robomore.tasks import get_task
from robomore.types import (
    Design,
    Evaluation,
    Job,
    Morphology,
    Reward,
    Slot,
    Status,
    TrainerSettings,
    Trial,
)

REFERENCE = Reward("1")
STEPS = 1000
"""Of a candidate in full."""


def context(observe: Observer = ignore, map_fn: MapFn = sequential_map) -> SearchContext:
    return SearchContext(
        task=get_task("swimmer"),
        reference=Design(Morphology((7.0,)), REFERENCE),
        candidate=Budget(STEPS, 1),
        evaluations=4,
        observe=observe,
        map_fn=map_fn,
    )


def context_of(task: str, evaluations: int) -> SearchContext:
    """Return the context of a search on a real task, with its own reference."""
    chosen = get_task(task)
    return replace(
        context(),
        task=chosen,
        reference=Design(Morphology(chosen.reference), Reward(chosen.reward)),
        evaluations=evaluations,
    )


def sizes(morphologies: int = 2, rewards: int = 2, **options: Any) -> RoboMoReSettings:
    """Settings without a reference column, so that all numbers are the designer's."""
    options.setdefault("reference_reward", "out")
    return RoboMoReSettings(morphologies, rewards, **options)


def robomore(
    designer: Designer,
    evaluate: Evaluate,
    settings: RoboMoReSettings,
    observe: Observer = ignore,
    map_fn: MapFn = sequential_map,
) -> list[Evaluation]:
    """Run the paper's method on numbers."""
    return RoboMoRe(settings).run(designer, evaluate, context(observe, map_fn))


class CountingDesigner:
    """Proposes 1, 2, 3, … and improves by steps that a test chooses."""

    name = "counting"
    reflects = True
    provenance = "No LLM was used: numbers in order."

    def __init__(self, step: float = 1.0) -> None:
        self.step = step
        self.asked: list[Slot] = []
        self.histories: list[tuple[str, ...]] = []

    def propose_morphology(self, slot: Slot, earlier: Sequence[Morphology]) -> Morphology:
        self.asked.append(slot)
        return Morphology((float(len(earlier) + 1),))

    def propose_reward(self, slot: Slot, earlier: Sequence[Reward]) -> Reward:
        self.asked.append(slot)
        return Reward(str(10 * (len(earlier) + 1)))

    def improve_morphology(
        self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]
    ) -> Morphology:
        self.asked.append(slot)
        self.histories.append(tuple(e.key for e in history))
        return Morphology((best.design.morphology.parameters[0] + self.step,))

    def improve_reward(self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]) -> Reward:
        self.asked.append(slot)
        return Reward(str(float(best.design.reward.source) + self.step))


class Measuring:
    """Evaluates `score(morphology, reward)`; a score of `None` is a failure. Keeps the batches."""

    def __init__(self, score: Callable[[float, float], float | None]) -> None:
        self.score = score
        self.batches: list[list[Trial]] = []

    def __call__(
        self, trials: Sequence[Trial], *, budget_fraction: float = 1.0
    ) -> list[Evaluation]:
        self.batches.append(list(trials))
        return [self.evaluation_of(trial.design) for trial in trials]

    def evaluation_of(self, design: Design) -> Evaluation:
        return evaluation(design, self.score(*numbers(design)))


def numbers(design: Design) -> tuple[float, float]:
    return design.morphology.parameters[0], float(design.reward.source)


def evaluation(design: Design, score: float | None) -> Evaluation:
    job = Job("none", design, TrainerSettings(), steps=1, episodes=1, seed=0)
    key = content_key(design.morphology.parameters, design.reward.source)
    if score is None:
        return Evaluation(key, job, Status.REWARD_FAILED, "it raised")
    return Evaluation(key, job, Status.OK, fitness=score / 2, volume=0.5, efficiency=score)
