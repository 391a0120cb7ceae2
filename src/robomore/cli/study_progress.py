"""Tells what a study does as it runs: each cell's result, and about how long all cells take."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from robomore.events import Event, Finished, Observer, RunBegan
from robomore.monitor import RunState
from robomore.monitor.remaining import roughly
from robomore.runs import Run
from robomore.runs.words import duration, in_unit
from robomore.studies import Cell

_SECONDS_BETWEEN_LINES = 60.0


@dataclass(slots=True)
class _Under:
    """A cell under way.

    Attributes:
        state: what its run has told.
        began: on the clock.
        runs: whether it really runs; one that was finished before only tells its result.
    """

    state: RunState
    began: float
    runs: bool = False


class StudyProgress:
    """Writes a line when a cell begins, when it has its result, and now and then in between.

    Cells may run side by side, each in a thread of its own.
    """

    def __init__(
        self,
        cells: Sequence[Cell],
        side_by_side: int,
        write: Callable[[str], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Begin.

        Args:
            cells: of the study.
            side_by_side: how many of them run at the same time.
            write: is given each line, its end included.
            clock: seconds that only grow.
        """
        self._cells = cells
        self._side_by_side = side_by_side
        self._write = write
        self._clock = clock
        self._lock = threading.Lock()
        self._most = [sum(cell.most_steps) for cell in cells]
        self._waiting = set(range(len(cells)))
        self._under_way: dict[int, _Under] = {}
        self._steps = self._seconds = 0.0
        """Most control steps of the cells that ran to their end by now, and seconds they took."""
        self._last = clock()

    def begin(self, index: int, cell: Cell) -> Observer:
        """Say that a cell begins; returns who observes its run."""
        with self._lock:
            under = _Under(RunState(self._clock), self._clock())
            self._under_way[index] = under
            self._waiting.discard(index)
            self._say(f"run {index + 1} of {len(self._cells)}: {cell.folder.name}")

        def observe(event: Event) -> None:
            with self._lock:
                under.state(event)
                under.runs = under.runs or isinstance(event, RunBegan)
                late = self._clock() - self._last >= _SECONDS_BETWEEN_LINES
                if late and isinstance(event, Finished):
                    state = under.state
                    done = f"{state.stage} {state.done}/{state.asked}"
                    self._say(f"{cell.folder.name}: {done}{self._left()}")

        return observe

    def measure(self, index: int, cell: Cell, count: int) -> None:
        """Say that a cell's policies are measured again."""
        with self._lock:
            policies = f"{count} polic{'y is' if count == 1 else 'ies are'}"
            self._say(f"{cell.folder.name}: {policies} measured again, for the curves")

    def end(self, index: int, cell: Cell, run: Run) -> None:
        """Say what a cell has found, and about how long the others take."""
        with self._lock:
            under = self._under_way.pop(index)
            took = self._clock() - under.began
            known = "kept from before"
            if under.runs:
                known = duration(took)
                self._steps += self._most[index]
                self._seconds += took
            self._say(f"{cell.folder.name}: {_result(run)} ({known}){self._left()}")

    def _left(self) -> str:
        """Return about how long all cells still take, `""` before anything was measured."""
        under_way = [self._left_of(index, one) for index, one in self._under_way.items()]
        known = [left for left in under_way if left is not None]
        if not self._waiting and not under_way:
            return ""
        pace = self._pace()
        if pace is None or len(known) < len(under_way):
            return ""
        waiting = pace * sum(self._most[index] for index in self._waiting)
        seconds = max((sum(known) + waiting) / self._side_by_side, max(known, default=0.0))
        return f"; about {roughly(seconds)} left for all runs"

    def _left_of(self, index: int, under: _Under) -> float | None:
        found = under.state.time_left()
        if found is None and self._steps:
            took = self._clock() - under.began
            return max(0.0, self._seconds / self._steps * self._most[index] - took)
        return found

    def _pace(self) -> float | None:
        """Return seconds for each control step that a cell may take at most.

        Cells that have ended tell it best: most end before they have used all of their steps.
        """
        if self._steps:
            return self._seconds / self._steps
        whole = most = 0.0
        for index, under in self._under_way.items():
            left = under.state.time_left()
            if left is not None:
                whole += left + self._clock() - under.began
                most += self._most[index]
        return whole / most if most else None

    def _say(self, line: str) -> None:
        self._last = self._clock()
        self._write(f"{line}\n")


def _result(run: Run) -> str:
    """Return what the search of a run found, trained anew, and what the reference design does."""
    found = run.found.score(run.objective) if run.found else None
    reference = run.reference.score(run.objective) if run.reference else None
    if found is None:
        return "found nothing that could be trained"
    said = in_unit(found.mean, run.objective, run.fitness_unit)
    if reference is None:
        return said
    beside = in_unit(reference.mean, run.objective, run.fitness_unit)
    return f"{said}, the reference design {beside}"
