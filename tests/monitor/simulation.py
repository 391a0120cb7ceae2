"""Whole runs in no time: a real search method and the final, workers and a clock that are made up.

Trainings take as long as a draw says, and the workers take them up as real ones do. Nothing else
about the order of events is made up: it comes from the method.
"""

from __future__ import annotations

import heapq
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from robomore.events import (
    BatchBegan,
    Event,
    Finished,
    Observer,
    Progressed,
    RunBegan,
    Started,
)
from robomore.identity import content_key
from robomore.monitor import RunState
from robomore.plan import Plan
from robomore.search import SearchContext, final, make_method
from robomore.search.budget import BudgetedEvaluate, BudgetSpent
from robomore.search.final import stage as final_stage
from robomore.settings import RunSettings
from robomore.tasks import get_task
from robomore.types import Design, Evaluation, Job, Morphology, Reward, Slot, Status, Trial

TASK = get_task("swimmer")
STEPS_PER_SECOND = 500.0


class Drawing:
    """A designer whose every proposal is another one."""

    name = "drawing"
    provenance = "Drawn for a test."
    reflects = True

    def __init__(self) -> None:
        self.count = 0

    def propose_morphology(self, slot: Slot, earlier: Sequence[Morphology]) -> Morphology:
        self.count += 1
        return Morphology((*TASK.reference[:-1], TASK.reference[-1] + 1e-6 * self.count))

    def propose_reward(self, slot: Slot, earlier: Sequence[Reward]) -> Reward:
        self.count += 1
        return Reward(f"# {self.count}")

    def improve_morphology(
        self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]
    ) -> Morphology:
        return self.propose_morphology(slot, ())

    def improve_reward(self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]) -> Reward:
        return self.propose_reward(slot, ())


@dataclass
class Workers:
    """Measures batches on a clock of its own, and tells an observer.

    Attributes:
        count: workers side by side.
        settings: of the run.
        observe: told what goes on.
        draw: makes up speeds, scores and failures.
        failing: fraction of the evaluations that fail at once.
        compiling: seconds that each worker's first training takes longer.
        around: seconds of loading before a training, and again of measuring after it.
        slower: factor by which the machine is slower from `slower_from` s on.
        now: seconds.
    """

    count: int
    settings: RunSettings
    observe: Observer
    draw: random.Random
    failing: float = 0.0
    compiling: float = 0.0
    around: float = 2.0
    slower: float = 1.0
    slower_from: float = 0.0
    now: float = 0.0
    begun: int = 0
    trained: dict[str, int] = field(default_factory=dict)
    known: dict[str, Evaluation] = field(default_factory=dict)
    scores: dict[str, float] = field(default_factory=dict)

    def measure(
        self, trials: Sequence[Trial], full: int, budget_fraction: float
    ) -> list[Evaluation]:
        """Measure a batch: the first worker that is free takes the next trial."""
        steps = round(budget_fraction * full)
        keys = [self._key(trial, steps) for trial in trials]
        asked = dict(zip(keys, trials, strict=True))
        known = [key for key in asked if key in self.known]
        self.observe(BatchBegan(tuple(trial.place for trial in asked.values()), len(known)))
        for key in known:
            self.observe(Finished(self.known[key], asked[key].place, known=True))
        waiting = [(key, trial) for key, trial in asked.items() if key not in self.known]
        happening: list[tuple[float, int, Event]] = []
        busy = 0
        while waiting or happening:
            while waiting and busy < self.count:
                key, trial = waiting.pop(0)
                for at, event in self._training(key, trial, steps):
                    heapq.heappush(happening, (at, len(happening) + 1000 * len(waiting), event))
                busy += 1
            self.now, _, event = heapq.heappop(happening)
            if isinstance(event, Finished):
                busy -= 1
                self.known[event.evaluation.key] = event.evaluation
            self.observe(event)
        return [self.known[key] for key in keys]

    def _training(self, key: str, trial: Trial, steps: int) -> list[tuple[float, Event]]:
        """Return what is told of one training, and when."""
        identity = self._key(trial, 0)
        before = self.trained.get(identity, 0)
        evaluation = self._evaluation(key, trial, steps)
        at = self.now
        told: list[tuple[float, Event]] = [(at, Started(key, trial.place, steps))]
        if evaluation.ok:
            self.trained[identity] = steps
            rate = STEPS_PER_SECOND * self.draw.lognormvariate(0.0, 0.2)
            at += self.around + (self.compiling if self.begun < self.count else 0.0)
            self.begun += 1
            if at > self.slower_from:
                rate /= self.slower
            for part in range(1, 4):
                done = (steps - before) * part // 3
                told.append((at + done / rate, Progressed(key, before + done)))
            at += (steps - before) / rate
        told.append((at + self.around, Finished(evaluation, trial.place, known=False)))
        return told

    def _evaluation(self, key: str, trial: Trial, steps: int) -> Evaluation:
        job = Job(TASK.id, trial.design, self.settings.trainer, steps, 1, trial.place.repeat)
        if trial.place.stage != "final" and self.draw.random() < self.failing:
            return Evaluation(key, job, Status.INVALID_REWARD, "refused")
        # Alike for one design, and for a design and the one it was made from.
        parent = self.known.get(trial.place.parent)
        like = parent.efficiency if parent and parent.efficiency else 1.0
        shift, spread = (-0.2, 0.3) if parent else (0.0, 1.0)
        like *= self.draw.lognormvariate(shift, spread)
        like = self.scores.setdefault(self._key(trial, 0), like)
        score = like * self.draw.lognormvariate(0.0, 0.1)
        return Evaluation(
            key, job, Status.OK, fitness=score, volume=1.0, efficiency=score, steps=steps
        )

    @staticmethod
    def _key(trial: Trial, steps: int) -> str:
        design = trial.design
        return content_key(
            design.morphology.parameters, design.reward.source, trial.place.repeat, steps
        )


def simulate(
    settings: RunSettings,
    workers: int,
    seed: int,
    failing: float = 0.0,
    budget_steps: int | None = None,
    time_limit: float | None = None,
    **machine: float,
) -> tuple[float, list[tuple[float, float | None]]]:
    """Return how long a made-up run took, and at every event (time, time left as estimated).

    `machine` are further fields of `Workers`.
    """
    method = make_method(settings.method)
    reference = Design(Morphology(TASK.reference), Reward(TASK.reward))
    context = SearchContext(
        task=TASK,
        reference=reference,
        candidate=settings.candidate,
        evaluations=settings.evaluations,
        seed=seed,
    )
    told: list[tuple[float, float | None]] = []

    def observe(event: Event) -> None:
        state(event)
        told.append((pool.now, state.time_left()))

    pool = Workers(workers, settings, observe, random.Random(seed), failing, **machine)
    clock: Callable[[], float] = lambda: pool.now  # noqa: E731
    state = RunState(clock)
    plan = Plan((*method.plan(context).stages, final_stage(settings.final)))
    observe(
        RunBegan(
            task=TASK.id,
            preset="made-up",
            settings=settings,
            plan=plan,
            designer="drawing",
            provenance=Drawing.provenance,
            seed=seed,
            workers=workers,
            folder=Path("none"),
            budget_steps=budget_steps,
            time_limit=time_limit,
        )
    )

    def search(trials: Sequence[Trial], *, budget_fraction: float = 1.0) -> list[Evaluation]:
        return pool.measure(trials, settings.candidate.steps, budget_fraction)

    def last(trials: Sequence[Trial], *, budget_fraction: float = 1.0) -> list[Evaluation]:
        return pool.measure(trials, settings.final.steps, budget_fraction)

    evaluate = BudgetedEvaluate(search, settings.candidate, budget_steps)
    try:
        best = method.run(Drawing(), evaluate, context)
    except BudgetSpent:
        best = evaluate.best(settings.objective)
    final(
        last,
        best[: settings.final.finalists],
        reference,
        settings.final.seeds,
        settings.objective,
    )
    return pool.now, told
