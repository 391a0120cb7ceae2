"""What a run has done so far, gathered from its events: counts, the best so far, the time left."""

from __future__ import annotations

import math
import time
from collections import Counter, deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

from robomore.events import (
    BatchBegan,
    Event,
    Finished,
    Progressed,
    Proposed,
    RunBegan,
    Spent,
    Started,
)
from robomore.settings import RunSettings
from robomore.types import Evaluation, Place, Status

_IDEAS = 3


@dataclass(slots=True)
class Running:
    """An evaluation that a worker is busy with."""

    place: Place
    total: int
    began: float
    steps: int = 0


@dataclass(frozen=True, slots=True)
class Remaining:
    """An estimate of the time left.

    Attributes:
        seconds: by the speed measured so far.
        kind: `at most` while the fine stage may still stop early, `about` in the final.
    """

    seconds: float
    kind: Literal["at most", "about"]


@dataclass(slots=True)
class Progress:
    """An observer that remembers.

    Attributes:
        clock: seconds that only grow.
        run: what was asked for, once it began.
        stage: `coarse`, `fine` or `final`; empty before the first batch.
        asked: places of the batch that is being measured.
        open: how many of them are not measured yet.
        running: evaluations under way, by key.
        counts: finished evaluations by status, those known from before among them.
        known: finished evaluations that were known from before.
        half_cycles: batches of the fine stage so far.
        best: of the search, by its objective, and where it was found.
        ideas: the latest proposals, newest last.
        spent: on a language model so far; `None` where none was asked.
        trouble: diagnosis of the latest failure.
    """

    clock: Callable[[], float] = time.monotonic
    run: RunBegan | None = None
    stage: str = ""
    asked: int = 0
    open: int = 0
    running: dict[str, Running] = field(default_factory=dict)
    counts: Counter[Status] = field(default_factory=Counter)
    known: int = 0
    half_cycles: int = 0
    best: tuple[Evaluation, Place] | None = None
    ideas: deque[Proposed] = field(default_factory=lambda: deque(maxlen=_IDEAS))
    spent: Spent | None = None
    trouble: str = ""
    began: float = 0.0
    _measured_steps: int = 0
    _measured_seconds: float = 0.0

    def __post_init__(self) -> None:
        self.began = self.clock()

    def __call__(self, event: Event) -> None:
        match event:
            case RunBegan():
                self.run = event
            case Proposed():
                self.ideas.append(event)
            case Spent():
                self.spent = event
            case BatchBegan(places):
                self.stage = places[0].stage if places else self.stage
                self.asked = self.open = len(places)
                self.half_cycles += self.stage == "fine"
                self.running.clear()
            case Started(key, place, steps):
                self.running[key] = Running(place, steps, self.clock())
            case Progressed(key, steps) if key in self.running:
                self.running[key].steps = steps
            case Finished(evaluation, place, known):
                self._finished(evaluation, place, known)

    @property
    def elapsed(self) -> float:
        """Seconds since the start."""
        return self.clock() - self.began

    @property
    def finished(self) -> int:
        """Evaluations that gave numbers or failed."""
        return self.counts.total()

    @property
    def failed(self) -> int:
        """Evaluations that failed."""
        return self.finished - self.counts[Status.OK]

    @property
    def objective(self) -> str:
        """What the search compares."""
        return self.run.settings.search.objective if self.run else "efficiency"

    def remaining(self) -> Remaining | None:
        """Return an estimate of the time left, or `None` before anything was measured."""
        rate = self._seconds_per_step()
        if rate is None or self.run is None:
            return None
        later = steps_after(self.run.settings, self.run.workers, self.stage, self.half_cycles)
        kind: Literal["at most", "about"] = "about" if self.stage == "final" else "at most"
        return Remaining(rate * (self._steps_in_batch() + later), kind)

    def _steps_in_batch(self) -> float:
        """Return the control steps that the busiest worker still has in this batch."""
        assert self.run is not None
        budget = self.run.settings.final if self.stage == "final" else self.run.settings.candidate
        done = sum(running.steps for running in self.running.values())
        left = max(0, self.open * budget.steps - done)
        # The last ones of a batch cannot be shared out any further.
        return max(left / self.run.workers, min(left, budget.steps) if self.open else 0)

    def _seconds_per_step(self) -> float | None:
        now = self.clock()
        seconds = self._measured_seconds + sum(now - r.began for r in self.running.values())
        steps = self._measured_steps + sum(r.steps for r in self.running.values())
        return seconds / steps if steps else None

    def _finished(self, evaluation: Evaluation, place: Place, known: bool) -> None:
        self.counts[evaluation.status] += 1
        self.known += known
        self.open -= 1
        running = self.running.pop(evaluation.key, None)
        if running and evaluation.ok:
            self._measured_steps += evaluation.steps
            self._measured_seconds += self.clock() - running.began
        if not evaluation.ok:
            self.trouble = f"{evaluation.status}: {evaluation.diagnosis}"
        score = evaluation.score(self.objective)
        if place.stage in ("screening", "final") or score is None:
            return
        if self.run and evaluation.job.steps < self.run.settings.candidate.steps:
            return  # Not trained to the end, so not to be compared with what is.
        former = self.best[0].score(self.objective) if self.best else None
        if former is None or score > former:
            self.best = evaluation, place


def steps_after(settings: RunSettings, workers: int, stage: str, half_cycles: int) -> int:
    """Return the control steps that the busiest worker has after the current batch, at most.

    Args:
        settings: of the run.
        workers: evaluations side by side.
        stage: of the current batch.
        half_cycles: batches of the fine stage so far, the current one included.
    """
    search = settings.search
    finals = math.ceil((search.finalists + 1) * search.repeats / workers) * settings.final.steps
    if stage == "final":
        return 0
    branches = max(1, math.floor(search.survivors * search.morphologies * search.rewards + 0.5))
    rounds = 2 * search.max_cycles - half_cycles
    return rounds * math.ceil(branches / workers) * settings.candidate.steps + finals
