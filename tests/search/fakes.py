"""A designer and an evaluator that need no robot: one number is the body, one the reward."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from robomore.identity import content_key
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
    """Evaluates `score(body, reward)`; a score of `None` is a failure. Keeps the batches."""

    def __init__(self, score: Callable[[float, float], float | None]) -> None:
        self.score = score
        self.batches: list[list[Trial]] = []

    def __call__(self, trials: Sequence[Trial], *, share: float = 1.0) -> list[Evaluation]:
        self.batches.append(list(trials))
        return [self.evaluation_of(trial.design) for trial in trials]

    def evaluation_of(self, design: Design) -> Evaluation:
        return evaluation(design, self.score(*numbers(design)))


def numbers(design: Design) -> tuple[float, float]:
    return design.morphology.parameters[0], float(design.reward.source)


def evaluation(design: Design, score: float | None) -> Evaluation:
    job = Job("none", design, TrainerSettings(), steps=1, episodes=1, seed=0)
    key = content_key(*numbers(design))
    if score is None:
        return Evaluation(key, job, Status.REWARD_FAILED, "it raised")
    return Evaluation(key, job, Status.OK, fitness=score / 2, volume=0.5, efficiency=score)
