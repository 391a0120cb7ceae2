"""How far a run is, written into its folder for whoever looks from outside.

The ledger tells what is finished; this tells what goes on meanwhile: a few hundred bytes, at most
once a second, so that no run is slower for it.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import msgspec

from robomore.errors import RunFolderError
from robomore.events import BatchBegan, Event, Finished, Observer, RunBegan
from robomore.monitor.state import RunState
from robomore.plain_files import read_plain, write_plain
from robomore.text import one_line, to_json

_SECONDS_BETWEEN = 1.0
_MOST_BYTES = 2**20
_LONGEST = 300


_MOST = 10**12

Seconds = Annotated[float, msgspec.Meta(ge=0, le=_MOST)]
Count = Annotated[int, msgspec.Meta(ge=0, le=_MOST)]
"""What a file says beyond these bounds no run has written."""


class Under(msgspec.Struct, frozen=True):
    """An evaluation under way: where in the run, and how much of its training is done, 0 to 1."""

    place: str
    share: Annotated[float, msgspec.Meta(ge=0, le=1)]


class Progress(msgspec.Struct, frozen=True, kw_only=True):
    """A run at one moment.

    Attributes:
        time: when, in seconds since 1970.
        elapsed: seconds since this process began.
        left: seconds that it about still takes; `None` before anything was measured.
        stage: of the current batch.
        asked: evaluations of the current batch.
        done: how many of them are measured.
        finished: evaluations that this process measured.
        failed: evaluations that failed, over the whole run.
        known: evaluations that were known from before.
        workers: evaluations that may go on side by side.
        running: evaluations under way.
        steps: control steps of training that the search has used.
        budget: control steps that it may use; `None` for no bound.
        trouble: the latest failure, in one line.
        over: whether the process has ended.
    """

    time: Seconds
    elapsed: Seconds
    left: Seconds | None
    stage: str
    asked: Count
    done: Count
    finished: Count
    failed: Count
    known: Count
    workers: Count
    running: tuple[Under, ...]
    steps: Count
    budget: Count | None
    trouble: str
    over: bool = False


class ProgressFile:
    """An observer that passes everything on, and keeps a file up to date.

    Args:
        path: of the file.
        observe: told everything.
        clock: seconds that only grow.
    """

    def __init__(
        self, path: Path, observe: Observer, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._path = path
        self._observe = observe
        self._clock = clock
        self._state = RunState(clock)
        self._written = -_SECONDS_BETWEEN

    def __call__(self, event: Event) -> None:
        self._observe(event)
        self._state(event)
        soon = isinstance(event, RunBegan | BatchBegan | Finished)
        # What ends is told soon, but a hundred known evaluations at once are told once.
        wait = _SECONDS_BETWEEN / 4 if soon else _SECONDS_BETWEEN
        if self._clock() - self._written >= wait:
            self._write(over=False)

    def close(self) -> None:
        """Say that the process has ended."""
        if self._state.run is not None:
            self._write(over=True)

    def _write(self, over: bool) -> None:
        self._written = self._clock()
        try:
            write_plain(self._path, to_json(progress_of(self._state, over)))
        except OSError:
            # Whatever is wrong with the disk, the ledger meets it too, and that stops the run.
            return


def progress_of(state: RunState, over: bool = False) -> Progress:
    """Return what a run's state is in short."""
    run = state.run
    return Progress(
        time=time.time(),
        elapsed=state.elapsed,
        left=0.0 if over else state.time_left(),
        stage=state.stage,
        asked=state.asked,
        done=state.done,
        finished=state.counts.total() - state.known,
        failed=state.failed,
        known=state.known,
        workers=run.workers if run else 0,
        running=tuple(
            Under(
                run.plan.describe(one.place) if run else "",
                min(1.0, one.steps / max(1, one.total)),
            )
            for one in state.running.values()
        ),
        steps=state.search_steps,
        budget=run.budget_steps if run else None,
        trouble=one_line(state.trouble)[:_LONGEST],
        over=over,
    )


def read_progress(path: Path) -> Progress | None:
    """Return what a run last told of itself; `None` if that is nothing, or no run writes it."""
    try:
        return msgspec.json.decode(read_plain(path, _MOST_BYTES), type=Progress)
    except (OSError, RunFolderError, msgspec.MsgspecError, RecursionError):
        return None
