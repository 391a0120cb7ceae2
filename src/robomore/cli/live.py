"""How a run is watched: a live picture in a terminal, plain lines everywhere else."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TextIO

from rich.console import Group, RenderableType
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from robomore.cli.output import console
from robomore.events import BatchBegan, Event, Finished, Observer, Proposed, RunBegan, Spent
from robomore.monitor.progress import Progress
from robomore.report.words import EFFICIENCY_UNIT, duration, number, place_name
from robomore.types import Evaluation, Place

_BAR = 32
_SECONDS_BETWEEN_LINES = 15.0
_LONGEST = 300
"""Characters of a line that somebody else may have written."""


@contextmanager
def watched(quiet: bool) -> Iterator[Observer]:
    """Show a run while the context lasts; gives the observer that the run is to tell.

    Args:
        quiet: show nothing.
    """
    if quiet:
        yield lambda event: None
        return
    screen = console(stderr=True)
    if not screen.is_terminal:
        yield PlainLines(sys.stderr)
        return
    view = LiveView()
    with Live(view, console=screen, refresh_per_second=4, transient=False):
        yield view


class LiveView:
    """A rich renderable that follows a run."""

    def __init__(self, progress: Progress | None = None) -> None:
        self._progress = progress or Progress()
        # Events come from the run's thread, drawing from the display's.
        self._lock = threading.Lock()

    def __call__(self, event: Event) -> None:
        with self._lock:
            self._progress(event)

    def __rich__(self) -> RenderableType:
        with self._lock:
            return render(self._progress)


def render(progress: Progress) -> RenderableType:
    """Return the picture of a run's state."""
    run = progress.run
    if run is None:
        return Text("preparing …")
    title = Text.assemble(
        (run.task, "bold"),
        f"  {run.preset}, designer {run.designer}, seed {run.seed}, "
        f"{_several(run.workers, 'worker')}",
    )
    parts: list[RenderableType] = [
        title,
        Text(run.provenance, style="dim"),
        _cut(f"containment: {run.containment}", "dim"),
        Text(),
    ]
    if progress.stage:
        done = progress.asked - progress.open
        stage = Table.grid(padding=(0, 1))
        stage.add_row(
            Text(f"{progress.stage:6}", style="bold"),
            ProgressBar(max(1, progress.asked), done, width=_BAR),
            Text(f"{done}/{progress.asked}  {_counted(progress)}"),
        )
        for running in progress.running.values():
            share = f"{running.steps:,}/{running.total:,} steps"
            stage.add_row(
                Text("  "),
                ProgressBar(max(1, running.total), running.steps, width=_BAR),
                Text(f"{share:>22}  {place_name(running.place)}", style="dim"),
            )
        parts.append(stage)
    if progress.best:
        parts.append(Text.assemble(("best   ", "bold"), _told(*progress.best)))
    for idea in progress.ideas:
        said = idea.failure or idea.idea
        parts.append(_cut(f"{idea.slot.kind:10} {said}", "dim"))
    if progress.spent and progress.spent.requests:
        parts.append(Text(_spending(progress.spent), style="dim"))
    if progress.trouble:
        first = progress.trouble.splitlines()[0]
        parts.append(_cut(f"last failure: {first}", "yellow"))
    parts.append(Text(_times(progress), style="dim"))
    return Group(*parts)


class PlainLines:
    """Writes a line when a stage begins, when something better is found, and now and then."""

    def __init__(self, stream: TextIO, clock: Callable[[], float] = time.monotonic) -> None:
        self._stream = stream
        self._clock = clock
        self._progress = Progress(clock)
        self._stage = ""
        self._last = -_SECONDS_BETWEEN_LINES

    def __call__(self, event: Event) -> None:
        progress = self._progress
        best = progress.best
        progress(event)
        if isinstance(event, RunBegan):
            self._say(
                f"{event.task}: {event.preset}, designer {event.designer}, seed {event.seed}, "
                f"{_several(event.workers, 'worker')}, into {event.folder}"
            )
            self._say(event.provenance)
            self._say(f"containment: {event.containment}")
        elif isinstance(event, BatchBegan) and progress.stage != self._stage:
            self._stage = progress.stage
            self._say(f"{progress.stage} stage: {_several(progress.asked, 'evaluation')}")
        elif isinstance(event, Proposed) and event.failure:
            # A model's own words may be quoted in it.
            why = "".join(c if c.isprintable() else " " for c in event.failure)[:_LONGEST]
            self._say(f"{event.slot}, attempt {event.slot.attempt + 1}: {why}")
        elif isinstance(event, Spent) and self._clock() - self._last >= _SECONDS_BETWEEN_LINES:
            self._say(f"{_spending(event)}; {_times(progress)}")
        elif isinstance(event, Finished) and not event.known:
            better = progress.best is not best
            late = self._clock() - self._last >= _SECONDS_BETWEEN_LINES
            last_word = event.place.stage == "final"
            if better or late or last_word or not event.evaluation.ok:
                self._say(_line(progress, event, better))

    def _say(self, line: str) -> None:
        self._last = self._clock()
        self._stream.write(line + "\n")
        self._stream.flush()


def _line(progress: Progress, event: Finished, better: bool) -> str:
    evaluation = event.evaluation
    if evaluation.ok:
        said = ("best so far: " if better else "") + _told(evaluation, event.place)
    else:
        first = (evaluation.diagnosis.splitlines() or [""])[0]
        said = f"{evaluation.status} ({place_name(event.place)}): {first}"
    done = progress.asked - progress.open
    return f"[{progress.stage} {done}/{progress.asked}] {said}; {_times(progress)}"


def _spending(spent: Spent) -> str:
    dollars = "of unknown price" if spent.dollars is None else f"${spent.dollars:.2f}"
    return f"language model: {spent.requests} requests, {spent.tokens:,} tokens, {dollars}"


def _several(count: int, name: str) -> str:
    return f"{count} {name}{'' if count == 1 else 's'}"


def _cut(line: str, style: str) -> Text:
    return Text(line, style=style, overflow="ellipsis", no_wrap=True)


def _counted(progress: Progress) -> str:
    said = f"{len(progress.running)} running, {progress.failed} failed"
    if progress.known:
        said += f", {progress.known} known from before"
    return said


def _told(evaluation: Evaluation, place: Place) -> str:
    return (
        f"{number(evaluation.efficiency)} {EFFICIENCY_UNIT} = {number(evaluation.fitness)} m / "
        f"{number(evaluation.volume)} m³ ({place_name(place)})"
    )


def _times(progress: Progress) -> str:
    remaining = progress.remaining()
    said = f"{duration(progress.elapsed)} so far"
    return f"{said}, {remaining.kind} {duration(remaining.seconds)} left" if remaining else said
