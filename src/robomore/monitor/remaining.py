"""How long a run still takes: what its plan still asks for, at the speed measured so far.

A training takes so long a control step, and so long besides: it is loaded before and measured
after. It is an estimate: a stage may end early, and no training is as fast as the next one.
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

CLOSING = 5.0
"""Seconds that the page and the champion's files take at the end, about."""

_LATEST = 12
"""Trainings by which the speed is judged: other programs come and go on a machine."""


@dataclass(frozen=True, slots=True)
class Timed:
    """How long a training took one worker.

    Attributes:
        steps: control steps between the first and the last time that it told of progress.
        seconds: that these took.
        around: seconds that it took besides: loading before its steps, and measuring after them;
            `None` where these cannot be told apart. The first one of a worker compiles while it
            loads, which says nothing of the others: of that one only the measuring counts.
    """

    steps: int
    seconds: float
    around: float | None


class Training(Protocol):
    """An evaluation under way: its steps in all and by now, and how long some of them took."""

    total: int
    steps: int

    def so_far(self) -> Timed | None:
        """Return what is known of its speed; `None` before it has told of progress."""
        ...


@dataclass(frozen=True, slots=True)
class Speed:
    """Seconds that one worker takes for a control step, and for what is around a training."""

    step: float
    around: float

    def seconds(self, steps: float, trainings: float = 1.0) -> float:
        """Return how long so many trainings take that have so many control steps together."""
        return self.step * steps + self.around * trainings


@dataclass(slots=True)
class Work:
    """What was asked for so far, and how fast it was done.

    Attributes:
        stage: name of the stage that the current batch counts for.
        target: control steps after which an evaluation of the current batch ends; 0 while unknown.
        batches: batches begun, by stage.
        used: control steps of training that are over, by stage.
        trained: control steps after which the training in a place rests; it may go on from there.
        timed: the latest trainings.
    """

    stage: str = ""
    target: int = 0
    batches: Counter[str] = field(default_factory=Counter)
    used: Counter[str] = field(default_factory=Counter)
    trained: dict[Place, int] = field(default_factory=dict)
    timed: deque[Timed] = field(default_factory=lambda: deque(maxlen=_LATEST))

    def begin(self, plan: Plan, stage: Stage) -> None:
        """Begin a batch. What only screens counts for the stage that it thins out."""
        if stage.role == "screening":
            own = next((s.name for s in plan.stages if s.role != "screening"), stage.name)
            self.stage = self.stage or own
        else:
            self.stage = stage.name
        self.target = 0
        self.batches[self.stage] += 1

    def finish(self, place: Place, steps: int, timed: Timed | None) -> None:
        """Note an evaluation; `timed` is `None` where its time says nothing of speed."""
        asked = max(0, steps - self.trained.get(place, 0))
        self.target = steps
        self.used[self.stage] += asked
        self.trained[place] = max(steps, self.trained.get(place, 0))
        if timed is not None:
            self.timed.append(timed)

    def speed(self, running: Iterable[Training]) -> Speed | None:
        """Return how fast one worker is; `None` before that is measured."""
        if not self.timed:
            return None
        under_way = (one.so_far() for one in running)
        timed = [*self.timed, *(one for one in under_way if one is not None)]
        around = [one.around for one in self.timed if one.around is not None]
        steps = sum(one.steps for one in timed)
        return Speed(sum(one.seconds for one in timed) / steps, fmean(around) if around else 0.0)


def seconds_left(
    run: RunBegan,
    work: Work,
    waiting: Mapping[int, int],
    running: Sequence[Training],
    leaders: Sequence[Evaluation],
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
        elapsed: seconds since the run began.
    """
    speed = work.speed(running)
    if speed is None:
        return None
    target = work.target or run.settings.candidate.steps
    steps_running = [one.total - one.steps for one in running]
    queued = {max(0, target - rests): count for rests, count in waiting.items()}
    # Of those under way, some are still to be loaded, and all are to be measured.
    under_way = [speed.seconds(steps, 0.5) for steps in steps_running]
    lengths = {speed.seconds(steps): count for steps, count in queued.items()}
    seconds = makespan(under_way, lengths, run.workers)
    steps_in_batch = sum(steps_running) + sum(steps * count for steps, count in queued.items())
    seconds += _after_this_batch(run, work, speed, steps_in_batch, leaders)
    if run.time_limit is not None:
        # What is under way when the time is up is still waited for.
        seconds = min(seconds, max(run.time_limit - elapsed, max(under_way, default=0.0)))
    return seconds + CLOSING


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
    run: RunBegan, work: Work, speed: Speed, in_batch: int, leaders: Sequence[Evaluation]
) -> float:
    """Return the seconds that pass after the current batch, as the busiest worker sees it."""
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
        passed += _passing(stage, speed, steps, batches, run.workers)
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


def _passing(stage: Stage, speed: Speed, steps: float, batches: float, workers: int) -> float:
    """Return how many seconds `steps` control steps of a stage take.

    At the end of each batch some workers wait for the last one: half an evaluation long, on
    average. And no batch is shorter than one evaluation.
    """
    if steps <= 0 or batches <= 0:
        return 0.0
    length = min(stage.steps / max(1, stage.evaluations), steps)
    one = speed.seconds(length)
    tail = batches * one * (1 - 1 / workers) / 2
    return max(batches * one, speed.seconds(steps, steps / length) / workers + tail)


def roughly(seconds: float) -> str:
    """Return a duration without digits that an estimate does not have."""
    if seconds < 90:
        return f"{max(10, round(seconds, -1)):.0f} s"
    if seconds < 2 * 3600:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h"
