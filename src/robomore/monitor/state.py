"""What goes on in a run, gathered from its events: counts, the best so far, and how fast it is."""

from __future__ import annotations

import time
from collections import Counter, deque
from collections.abc import Callable
from dataclasses import dataclass, field

from robomore.events import (
    BatchBegan,
    Event,
    Finished,
    Progressed,
    Proposed,
    RunBegan,
    Spent,
    Started,
    Waiting,
)
from robomore.monitor.remaining import Timed, Work, seconds_left
from robomore.plan import Stage
from robomore.types import Evaluation, Place, Slot, Status

_IDEAS = 3


@dataclass(slots=True)
class Running:
    """An evaluation that a worker is busy with.

    Attributes:
        place: where in the run.
        total: control steps of its training.
        before: how many of them were done when it began; its training goes on from there.
        steps: how many are done by now.
        began: on the clock.
        compiles: whether it is the first of its worker, whose start says nothing of the others.
        told: when it first told of progress, and how many steps were done then.
        latest: when it last did.
    """

    place: Place
    total: int
    before: int
    steps: int
    began: float
    compiles: bool
    told: tuple[float, int] | None = None
    latest: float = 0.0

    def progressed(self, steps: int, now: float) -> None:
        """Note how many control steps are done."""
        self.steps, self.latest = max(steps, self.before), now
        self.told = self.told or (now, self.steps)

    def so_far(self) -> Timed | None:
        """Return how fast it is, from when on it told of progress."""
        if self.told is None or self.steps <= self.told[1]:
            return None
        return Timed(self.steps - self.told[1], self.latest - self.told[0], None)

    def ended(self, now: float) -> Timed | None:
        """Return how long it took; `None` where it had nothing to do."""
        asked, whole = self.total - self.before, now - self.began
        if self.told is None or 2 * (self.steps - self.told[1]) < asked:
            # It told of too little to tell its steps from what is around them.
            return Timed(asked, whole, None) if asked else None
        steps, seconds = self.steps - self.told[1], self.latest - self.told[0]
        if self.compiles:
            whole, asked = now - self.latest, self.total - self.steps
        return Timed(steps, seconds, max(0.0, whole - seconds / steps * asked))


@dataclass(slots=True)
class RunState:
    """An observer that remembers.

    Attributes:
        clock: seconds that only grow.
        run: what was asked for, once it began.
        stage: name of the current batch's stage; empty before the first batch.
        batch: evaluations of the current batch.
        before: evaluations of earlier batches of the same stage.
        open: places of the current batch that are not measured yet, each with the control steps
            that its training rests at.
        running: evaluations under way, by key.
        counts: finished evaluations by status, those known from before among them.
        known: finished evaluations that were known from before.
        leaders: the best of the search and where they were found, best first; as many as there
            will be finalists.
        ideas: the latest proposals, newest last.
        spent: on a language model so far; `None` where none was asked.
        asked_model: slots that a language model is asked to fill, and when it was asked.
        trouble: diagnosis of the latest failure.
        began: on the clock.
    """

    clock: Callable[[], float] = time.monotonic
    run: RunBegan | None = None
    stage: str = ""
    batch: int = 0
    before: int = 0
    open: dict[Place, int] = field(default_factory=dict)
    running: dict[str, Running] = field(default_factory=dict)
    counts: Counter[Status] = field(default_factory=Counter)
    known: int = 0
    leaders: list[tuple[Evaluation, Place]] = field(default_factory=list)
    ideas: deque[Proposed] = field(default_factory=lambda: deque(maxlen=_IDEAS))
    spent: Spent | None = None
    asked_model: dict[Slot, float] = field(default_factory=dict)
    trouble: str = ""
    began: float = 0.0
    _taken_up: int = 0
    _work: Work = field(default_factory=Work)
    _waiting: Counter[int] = field(default_factory=Counter)
    """Places of the current batch that no worker has taken up, by the steps that they rest at. A
    batch may have any number of them, and they are looked at several times a second."""
    _started: set[Place] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.began = self.clock()

    def __call__(self, event: Event) -> None:
        match event:
            case RunBegan():
                self.run = event
            case Proposed():
                self.ideas.append(event)
            case Waiting(slot, over):
                if over:
                    self.asked_model.pop(slot, None)
                else:
                    self.asked_model[slot] = self.clock()
            case Spent():
                self.spent = event
            case BatchBegan(places):
                self._batch_began(places)
            case Started(key, place, steps):
                before = self._work.trained.get(place, 0)
                first = self.run is not None and self._taken_up < self.run.workers
                self.running[key] = Running(place, steps, before, before, self.clock(), first)
                self._taken_up += 1
                self._work.target = steps
                self._start(place)
            case Progressed(key, steps) if key in self.running:
                self.running[key].progressed(steps, self.clock())
            case Finished(evaluation, place, known):
                self._finished(evaluation, place, known)

    @property
    def elapsed(self) -> float:
        """Seconds since the start."""
        return self.clock() - self.began

    @property
    def waited(self) -> float | None:
        """Seconds since the longest open question to a language model; `None` without one."""
        since = min(self.asked_model.values(), default=None)
        return None if since is None else self.clock() - since

    @property
    def done(self) -> int:
        """Evaluations of the current stage that are measured."""
        return self.before + self.batch - len(self.open)

    @property
    def asked(self) -> int:
        """Evaluations of the current stage: the most that it may have, as far as is known."""
        planned = self.run.plan.stage(self.stage).evaluations if self.run else 0
        return max(self.before + self.batch, planned if self._in_batches(self.stage) else 0)

    @property
    def failed(self) -> int:
        """Evaluations that failed, over the whole run."""
        return self.counts.total() - self.counts[Status.OK]

    @property
    def best(self) -> tuple[Evaluation, Place] | None:
        """The best of the search, by its objective, and where it was found."""
        return self.leaders[0] if self.leaders else None

    @property
    def search_steps(self) -> int:
        """Control steps of training that the search has used, the final left out."""
        return sum(
            steps
            for name, steps in self._work.used.items()
            if self.run is None or self.run.plan.stage(name).role != "final"
        )

    @property
    def objective(self) -> str:
        """What the search compares."""
        return self.run.settings.objective if self.run else "efficiency"

    def time_left(self) -> float | None:
        """Return about how many seconds are left, or `None` before anything was measured."""
        if self.run is None:
            return None
        running = list(self.running.values())
        leaders = [evaluation for evaluation, _ in self.leaders]
        return seconds_left(self.run, self._work, self._waiting, running, leaders, self.elapsed)

    def _stage(self, place: Place) -> Stage:
        return self.run.plan.stage(place.stage) if self.run else Stage(name=place.stage)

    def _in_batches(self, name: str) -> bool:
        """Return whether a stage searches in several batches, each with new designs."""
        stage = self.run.plan.stage(name) if self.run else Stage(name=name)
        return stage.role == "search" and stage.batches > 1

    def _batch_began(self, places: tuple[Place, ...]) -> None:
        before, stage = self.before + self.batch, self.stage
        self.stage = places[0].stage if places else stage
        self.before = before if self.stage == stage and self._in_batches(stage) else 0
        trained = self._work.trained
        self.open = {place: trained.get(place, 0) for place in places}
        self.batch = len(self.open)
        self._waiting = Counter(self.open.values())
        self._started.clear()
        self.running.clear()
        if places and self.run:
            self._work.begin(self.run.plan, self._stage(places[0]))

    def _start(self, place: Place) -> None:
        if place in self.open and place not in self._started:
            self._started.add(place)
            self._waiting[self.open[place]] -= 1

    def _finished(self, evaluation: Evaluation, place: Place, known: bool) -> None:
        self.counts[evaluation.status] += 1
        self.known += known
        self._start(place)
        self.open.pop(place, None)
        running = self.running.pop(evaluation.key, None)
        # One that fails ends early.
        timed = running.ended(self.clock()) if running and evaluation.ok else None
        self._work.finish(place, evaluation.job.steps, timed)
        if not evaluation.ok:
            self.trouble = f"{evaluation.status}: {evaluation.diagnosis}"
        elif self._stage(place).role == "search":
            self._rank(evaluation, place)

    def _rank(self, evaluation: Evaluation, place: Place) -> None:
        if self.run is None or evaluation.job.steps < self.run.settings.candidate.steps:
            return  # What was not trained to the end is not to be compared with what was.
        if all(evaluation.design != other.design for other, _ in self.leaders):
            self.leaders.append((evaluation, place))
            # Equals stay in the order in which they were found.
            self.leaders.sort(key=lambda one: -(one[0].score(self.objective) or 0.0))
            del self.leaders[self.run.settings.final.finalists :]
