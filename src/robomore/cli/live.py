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
from robomore.monitor import RunState
from robomore.monitor.remaining import roughly
from robomore.options import settings_words
from robomore.runs.scores import scored
from robomore.runs.words import duration
from robomore.text import one_line
from robomore.types import Evaluation, Place

_BAR = 20
_SECONDS_BETWEEN_LINES = 15.0
_SECONDS_TO_REMIND = 4.0
"""Seconds without an answer of a language model, after which a plain line says so."""
_SECONDS_BETWEEN_REMINDERS = 30.0
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
        lines = PlainLines(sys.stderr)
        try:
            yield lines
        finally:
            lines.close()
        return
    view = LiveView()
    with Live(view, console=screen, refresh_per_second=4, transient=False):
        yield view


class LiveView:
    """A rich renderable that follows a run."""

    def __init__(self, state: RunState | None = None) -> None:
        self._state = state or RunState()
        # Events come from the run's thread, drawing from the display's.
        self._lock = threading.Lock()

    def __call__(self, event: Event) -> None:
        with self._lock:
            self._state(event)

    def __rich__(self) -> RenderableType:
        with self._lock:
            return render(self._state)


def render(state: RunState) -> RenderableType:
    """Return the picture of a run's state. It fits 80 columns."""
    run = state.run
    if run is None:
        return Text("preparing …")
    parts: list[RenderableType] = [
        Text.assemble((run.task, "bold"), f"  {_settings(run)}"),
        _cut(run.provenance, "dim"),
        _cut(f"containment: {run.containment}", "dim"),
        Text(),
    ]
    if state.stage:
        stage = Table.grid(padding=(0, 1))
        stage.add_row(
            Text(state.stage, style="bold"),
            ProgressBar(max(1, state.asked), state.done, width=_BAR),
            Text(f"{state.done}/{state.asked}  {_counted(state)}"),
        )
        parts.append(stage)
        training = Table.grid(padding=(0, 1))
        for running in state.running.values():
            where = run.plan.describe(running.place).removeprefix(f"{state.stage}: ")
            training.add_row(
                ProgressBar(max(1, running.total), running.steps, width=_BAR),
                Text(f"{100 * running.steps / max(1, running.total):3.0f} %", style="dim"),
                _cut(where, "dim"),
            )
        parts.append(training)
    if state.best:
        parts.append(Text.assemble(("best  ", "bold"), _told(state, *state.best)))
    for idea in state.ideas:
        parts.append(_cut(f"{idea.slot.kind:10} {idea.failure or idea.idea}", "dim"))
    if state.asked_model:
        parts.append(_cut(_waiting(state), "dim"))
    if state.spent and state.spent.requests:
        parts.append(Text(_spending(state.spent), style="dim"))
    if state.trouble:
        parts.append(_cut(f"last failure: {state.trouble.splitlines()[0]}", "yellow"))
    parts.append(Text(_times(state), style="dim"))
    return Group(*parts)


class PlainLines:
    """Writes a line when a stage begins, when something better is found, and now and then.

    While a language model is waited for, nothing happens that it could be told. So a timer reminds
    it, in a thread of its own.
    """

    def __init__(self, stream: TextIO, clock: Callable[[], float] = time.monotonic) -> None:
        self._stream = stream
        self._clock = clock
        self._state = RunState(clock)
        self._stage = ""
        self._last = -_SECONDS_BETWEEN_LINES
        self._lock = threading.Lock()
        self._timer: threading.Timer | None = None

    def __call__(self, event: Event) -> None:
        with self._lock:
            self._tell(event)
            if not self._state.asked_model:
                self._cancel()
            elif self._timer is None:
                self._set_timer(_SECONDS_TO_REMIND)

    def remind(self) -> None:
        """Say for how long a language model has been waited for, and do so again later."""
        with self._lock:
            self._timer = None
            if self._state.asked_model:
                self._say(_waiting(self._state))
                self._set_timer(_SECONDS_BETWEEN_REMINDERS)

    def close(self) -> None:
        """Remind of nothing any more."""
        with self._lock:
            self._cancel()

    def _set_timer(self, seconds: float) -> None:
        self._timer = threading.Timer(seconds, self.remind)
        # A thread that waits must not keep the program alive.
        self._timer.daemon = True
        self._timer.start()

    def _cancel(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _tell(self, event: Event) -> None:
        state = self._state
        best = state.best
        state(event)
        late = self._clock() - self._last >= _SECONDS_BETWEEN_LINES
        match event:
            case RunBegan():
                self._say(f"{event.task}: {_settings(event)}, into {event.folder}")
                self._say(event.provenance)
                self._say(f"containment: {event.containment}")
            case BatchBegan(known=known) if state.stage != self._stage:
                self._stage = state.stage
                kept = f", of which {known} are kept from before" if known else ""
                begins = f"{_several(state.batch, 'evaluation')} to begin with"
                self._say(f"{state.stage}: {begins}{kept}")
            case Proposed() if event.failure:
                why = one_line(event.failure)[:_LONGEST]
                self._say(f"{event.slot}, attempt {event.slot.attempt + 1}: {why}")
            case Spent() if late:
                self._say(f"{_spending(event)}; {_times(state)}")
            case Finished(known=False):
                better = state.best is not None and state.best != best
                final = state.run and state.run.plan.stage(event.place.stage).role == "final"
                if better or late or final or not event.evaluation.ok:
                    self._say(_line(state, event, better))

    def _say(self, line: str) -> None:
        self._last = self._clock()
        self._stream.write(one_line(line) + "\n")
        self._stream.flush()


def _settings(run: RunBegan) -> str:
    designer = f"designer {run.designer}" if run.designer else "no designer"
    return (
        f"{settings_words(run.preset, run.settings)}; method {run.settings.method.name}, "
        f"{designer}, seed {run.seed}, "
        f"{_several(run.workers, 'worker')}"
    )


def _line(state: RunState, event: Finished, better: bool) -> str:
    evaluation = event.evaluation
    if evaluation.ok:
        said = ("best so far: " if better else "") + _told(state, evaluation, event.place)
    else:
        first = (evaluation.diagnosis.splitlines() or [""])[0]
        said = f"{evaluation.status} ({_where(state, event.place)}): {first}"
    return f"[{state.stage} {state.done}/{state.asked}] {said}; {_times(state)}"


def _waiting(state: RunState) -> str:
    slots = list(state.asked_model)
    more = f" and {len(slots) - 1} more" if len(slots) > 1 else ""
    return f"waiting for the language model, {duration(state.waited or 0.0)} …  ({slots[0]}{more})"


def _spending(spent: Spent) -> str:
    dollars = "of unknown price" if spent.dollars is None else f"${spent.dollars:.2f}"
    return f"language model: {spent.requests} requests, {spent.tokens:,} tokens, {dollars}"


def _several(count: int, name: str) -> str:
    return f"{count} {name}{'' if count == 1 else 's'}"


def _cut(line: str, style: str) -> Text:
    return Text(line, style=style, overflow="ellipsis", no_wrap=True)


def _counted(state: RunState) -> str:
    said = f"{len(state.running)} running, {state.failed} failed"
    return f"{said}, {state.known} known from before" if state.known else said


def _where(state: RunState, place: Place) -> str:
    return state.run.plan.describe(place) if state.run else place.stage


def _told(state: RunState, evaluation: Evaluation, place: Place) -> str:
    unit = state.run.fitness_unit if state.run else ""
    return f"{scored(evaluation, state.objective, unit)} ({_where(state, place)})"


def _times(state: RunState) -> str:
    """Return what was used of the run's limits, and about how long it still takes."""
    run = state.run
    said = duration(state.elapsed)
    if run and run.time_limit is not None:
        said += f" of {duration(run.time_limit)}"
    said += " so far"
    if run and run.budget_steps is not None:
        said += f", {state.search_steps:,} of {run.budget_steps:,} control steps"
    left = state.time_left()
    return f"{said}, about {roughly(left)} left" if left else said
