"""How long a run still takes: what its plan still asks for, at the speed measured so far.

Everything is counted in control steps of training and turned into seconds at the end. It is an
estimate: a stage may end early, and no training is as fast as the next one.
"""

from __future__ import annotations

import heapq
from collections import Counter, deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from statistics import fmean
from typing import Protocol

from robomore.events import RunBegan
from robomore.plan import Plan, Stage
from robomore.tasks import get_task
from robomore.types import Design, Evaluation, Place

_LATEST = 12
"""Trainings by which the speed is judged: other programs come and go on a machine."""


class Training(Protocol):
    """An evaluation under way: its steps in all and by now, and from where it is timed."""

    total: int
    steps: int
    timed_steps: int
    timed_from: float | None


@dataclass(slots=True)
class Work:
    """What was asked for so far, and how fast it was done.

    Attributes:
        stage: name of the stage that the current batch counts for.
        target: control steps after which an evaluation of the current batch ends; 0 while unknown.
        batches: batches begun, by stage.
        used: control steps of training that are over, by stage.
        trained: control steps after which the training in a place rests; it may go on from there.
        timed: the latest trainings, as (control steps, seconds that these took one worker).
    """

    stage: str = ""
    target: int = 0
    batches: Counter[str] = field(default_factory=Counter)
    used: Counter[str] = field(default_factory=Counter)
    trained: dict[Place, int] = field(default_factory=dict)
    timed: deque[tuple[int, float]] = field(default_factory=lambda: deque(maxlen=_LATEST))

    def begin(self, plan: Plan, stage: Stage) -> None:
        """Begin a batch. What only screens counts for the stage that it thins out."""
        if stage.role == "screening":
            own = next((s.name for s in plan.stages if s.role != "screening"), stage.name)
            self.stage = self.stage or own
        else:
            self.stage = stage.name
        self.target = 0
        self.batches[self.stage] += 1

    def finish(self, place: Place, steps: int, timed: tuple[int, float] | None) -> None:
        """Note an evaluation; `timed` is `None` where its time says nothing of speed."""
        asked = max(0, steps - self.trained.get(place, 0))
        self.target = steps
        self.used[self.stage] += asked
        self.trained[place] = max(steps, self.trained.get(place, 0))
        if timed is not None:
            self.timed.append(timed)

    def seconds_per_step(self, running: Iterable[Training], now: float) -> float | None:
        """Return how long one worker takes for a control step; `None` before it is measured."""
        steps = float(sum(steps for steps, _ in self.timed))
        seconds = sum(seconds for _, seconds in self.timed)
        if not steps:
            return None
        for one in running:
            if one.timed_from is not None:
                steps += one.steps - one.timed_steps
                seconds += now - one.timed_from
        return seconds / steps


def seconds_left(
    run: RunBegan,
    work: Work,
    waiting: Mapping[int, int],
    running: Sequence[Training],
    leaders: Sequence[Evaluation],
    now: float,
    elapsed: float,
) -> float | None:
    """Return about how many seconds a run still takes; `None` before anything was measured.

    Args:
        run: what was asked for, its plan and limits among it.
        work: what was done of it.
        waiting: how many evaluations of the current batch no worker has taken up, by the control
            steps that their training rests at.
        running: what the workers are busy with.
        leaders: the best of the search so far, as many as will be finalists.
        now: on the clock by which `running` began.
        elapsed: seconds since the run began.
    """
    pace = work.seconds_per_step(running, now)
    if pace is None:
        return None
    target = work.target or run.settings.candidate.steps
    under_way = [float(one.total - one.steps) for one in running]
    queued = {float(max(0, target - rests)): count for rests, count in waiting.items()}
    all_queued = sum(length * count for length, count in queued.items())
    left = makespan(under_way, queued, run.workers)
    left += _after_this_batch(run, work, sum(under_way) + all_queued, leaders)
    seconds = pace * left
    if run.time_limit is not None:
        # What is under way when the time is up is still waited for.
        ending = pace * max(under_way, default=0.0)
        seconds = min(seconds, max(run.time_limit - elapsed, ending))
    return seconds


def makespan(running: Iterable[float], waiting: Mapping[float, int], workers: int) -> float:
    """Return when the last of some trainings ends, if the first free worker takes the next one.

    Args:
        running: what is left of those under way.
        waiting: how many others there are of each length.
        workers: that there are.
    """
    busy = list(running)
    busy += [0.0] * (workers - len(busy))
    heapq.heapify(busy)
    for length, count in waiting.items():
        # Once workers are level, each takes one in every round. Rounds need not be played.
        rounds = max(0, count // len(busy) - _PLAYED)
        for _ in range(count - rounds * len(busy)):
            heapq.heapreplace(busy, busy[0] + length)
        busy = [end + rounds * length for end in busy]
    return max(busy)


_PLAYED = 4
"""Rounds of the workers after which they count as level."""


def _after_this_batch(
    run: RunBegan, work: Work, in_batch: float, leaders: Sequence[Evaluation]
) -> float:
    """Return the control steps that pass after the current batch, as the busiest worker sees it."""
    stages = run.plan.stages
    names = [stage.name for stage in stages]
    current = names.index(work.stage) if work.stage in names else 0
    final = {stage.name for stage in stages if stage.role == "final"}
    asked = {**work.used, work.stage: work.used[work.stage] + in_batch}
    budget = float("inf")
    if run.budget_steps is not None:
        budget = run.budget_steps - sum(n for name, n in asked.items() if name not in final)
    passed = 0.0
    for stage in stages[current:]:
        share = stage.typical if stage.role != "final" else _share_of_final(run, leaders)
        steps = share * stage.steps - asked.get(stage.name, 0)
        if stage.role == "search":
            steps = min(steps, budget)
            budget -= max(0.0, steps)
        batches = share * stage.batches - work.batches[stage.name]
        passed += _passing(stage, steps, batches, run.workers)
    return passed


def _share_of_final(run: RunBegan, leaders: Sequence[Evaluation]) -> float:
    """Return the share of the final's trainings that no other one of them repeats.

    It crosses the best design with the reference. Where these have one half in common, the crossed
    pairs are the two designs themselves.
    """
    if not leaders:
        return 1.0
    task, count = get_task(run.task), run.settings.final.finalists

    def beside_reference(design: Design) -> int:
        new = design.morphology.parameters != task.reference, design.reward.source != task.reward
        return (0, 1, 3)[sum(new)]

    other = fmean(beside_reference(evaluation.design) for evaluation in leaders)
    return (count + other) / (count + 3)


def _passing(stage: Stage, steps: float, batches: float, workers: int) -> float:
    """Return how many control steps of one worker `steps` of a stage take.

    At the end of each batch some workers wait for the last one: half an evaluation long, on
    average. And no batch is shorter than one evaluation.
    """
    if steps <= 0 or batches <= 0:
        return 0.0
    one = min(stage.steps / max(1, stage.evaluations), steps)
    tail = batches * one * (1 - 1 / workers) / 2
    return max(batches * one, steps / workers + tail)
