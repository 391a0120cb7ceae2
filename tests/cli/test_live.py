"""How a run is watched: the live view and the plain lines, told by events and our own clock."""

from __future__ import annotations

import io
import re
import time
from dataclasses import replace

import pytest
from rich.console import Console

from monitor.told import (
    BEGAN,
    GRID,
    LAST,
    LATER,
    Clock,
    clock,
    failed,
    measured,
    state,
)
from robomore.cli.live import LiveView, PlainLines, render
from robomore.events import BatchBegan, Finished, Proposed, Spent, Started, Waiting
from robomore.monitor import RunState
from robomore.types import Slot

__all__ = ["clock", "state"]


def shown(state: RunState, width: int = 80) -> str:
    screen = Console(file=io.StringIO(), width=width)
    screen.print(render(state))
    assert isinstance(screen.file, io.StringIO)
    return screen.file.getvalue()


def test_the_live_view_shows_all_of_it_and_takes_ideas_for_text(state: RunState) -> None:
    text = shown(state)
    assert "No LLM was used." in text
    assert "containment: strict (files)" in text
    assert "2/4" in text
    assert "1 running, 1 failed" in text
    assert " 50 % morphology 1, reward 2" in text
    assert "6.000 m/m³ = 3.000 m / 0.5000 m³ (matrix: morphology 1, reward 1)" in text
    assert "long [legs]" in text
    assert "last failure: reward-failed: line 3: [bold]NameError" in text
    assert "10 s so far, about 80 s left" in text


def test_the_live_view_fits_eighty_columns(state: RunState) -> None:
    assert state.run is not None
    long = "proposed by a model of a very long name " * 4
    state(replace(state.run, provenance=long, containment=long))
    state(Proposed(Slot("matrix", "reward", (1,)), long, long))
    state(BatchBegan(LAST, known=0))
    crossed = replace(LAST[0], changed="found morphology, reference reward", repeat=5)
    state(Started("z", crossed, 2_000))
    lines = shown(state).splitlines()
    assert max(map(len, lines)) <= 80
    assert len(lines) < 16
    assert any("found morphology, reference reward, training seed 5" in line for line in lines)


def test_limits_are_shown_where_they_are_set(state: RunState) -> None:
    assert "of" not in shown(state).splitlines()[-1]
    assert state.run is not None
    state(replace(state.run, budget_steps=9_000, time_limit=1_800.0))
    assert "10 s of 30 min 00 s so far, 2,000 of 9,000 control steps, about" in shown(state)


def test_a_method_that_asks_no_designer_says_so(state: RunState) -> None:
    assert "preset quick; method ours, designer offline, seed 3, 2 workers" in shown(state)
    state(replace(BEGAN, designer=""))
    assert "no designer" in shown(state)


def test_the_live_view_can_be_drawn_at_any_moment(clock: Clock) -> None:
    view = LiveView(RunState(clock))
    Console(file=io.StringIO()).print(view)
    started = Started("a", GRID[0], 1_000)
    for event in (BEGAN, BatchBegan(GRID, 0), started, BatchBegan((LATER,), 0)):
        view(event)
        Console(file=io.StringIO()).print(view)


def test_the_score_that_is_compared_comes_first(state: RunState) -> None:
    assert re.search(r"best +\S+ m/m³ = \S+ m / \S+ m³", shown(state))
    assert state.run is not None
    settings = replace(state.run.settings, objective="fitness")
    state(replace(state.run, settings=settings))
    best = next(line for line in shown(state).splitlines() if line.startswith("best"))
    assert re.search(r"best +\S+ m; \S+ m / \S+ m³ = \S+ m/m³", best)


def test_plain_lines_tell_stages_bests_and_failures_but_not_everything(clock: Clock) -> None:
    stream = io.StringIO()
    lines = PlainLines(stream, clock)
    lines(BEGAN)
    lines(BatchBegan(GRID, 0))
    lines(Finished(measured("a", 3.0), GRID[0], known=False))
    lines(Finished(measured("b", 2.0), GRID[1], known=False))
    lines(Finished(failed("c"), GRID[2], known=False))
    clock.now += 60
    lines(Finished(measured("d", 1.0), GRID[3], known=False))
    first, provenance, contained, stage, best, failure, late = stream.getvalue().splitlines()
    assert "2 workers" in first
    assert provenance == "No LLM was used."
    assert contained == "containment: strict (files)"
    assert stage == "matrix: 4 evaluations to begin with"
    assert best.startswith("[matrix 1/4] best so far: 6.000")
    assert "reward-failed" in failure
    assert late.startswith("[matrix 4/4] 2.000")


def test_what_is_kept_from_before_is_told(clock: Clock) -> None:
    stream = io.StringIO()
    lines = PlainLines(stream, clock)
    lines(BEGAN)
    lines(BatchBegan(GRID, known=3))
    said = stream.getvalue().splitlines()[-1]
    assert said == "matrix: 4 evaluations to begin with, of which 3 are kept from before"


def test_plain_lines_tell_of_slots_that_failed_and_now_and_then_of_the_bill(clock: Clock) -> None:
    stream = io.StringIO()
    lines = PlainLines(stream, clock)
    lines(BEGAN)
    lines(Spent(1, 500, None))
    lines(Proposed(Slot("matrix", "reward", (1,), attempt=2), "", "no\n\x1b[2J" + "o" * 5_000))
    clock.now += 60
    lines(Spent(12, 34_000, 0.256))
    *_, failure, spent = stream.getvalue().split("\n")[:-1]
    assert failure.startswith("matrix reward 2, attempt 3: no ") and len(failure) < 400
    assert "\x1b" not in failure
    assert spent.startswith("language model: 12 requests, 34,000 tokens, $0.26; 1 min 00 s so far")
    assert stream.getvalue().count("language model") == 1


def test_the_live_view_shows_the_bill(state: RunState) -> None:
    console = Console(file=io.StringIO(), width=100)
    state(Spent(3, 4_000, None))
    console.print(render(state))
    assert "language model: 3 requests, 4,000 tokens, of unknown price" in console.file.getvalue()


def test_a_language_model_that_is_waited_for_is_seen_to_be(state: RunState, clock: Clock) -> None:
    first, second = (Slot("matrix", "morphology", (index,)) for index in range(2))
    state(Waiting(first))
    state(Waiting(second))
    clock.now += 12
    said = "waiting for the language model, 12 s … (matrix morphology 1"
    assert said in " ".join(shown(state).split())
    state(Waiting(first, over=True))
    state(Waiting(second, over=True))
    assert "waiting" not in shown(state)


def test_plain_lines_say_so_too_and_no_longer_than_it_lasts(
    clock: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("robomore.cli.live._SECONDS_TO_REMIND", 0.01)
    stream = io.StringIO()
    lines = PlainLines(stream, clock)
    lines(BEGAN)
    slot = Slot("matrix", "morphology", (0,))
    lines(Waiting(slot))
    clock.now += 4
    deadline = time.monotonic() + 20
    while "waiting" not in stream.getvalue() and time.monotonic() < deadline:
        time.sleep(0.01)
    assert "waiting for the language model, 4 s" in stream.getvalue()
    before = stream.getvalue()
    lines(Waiting(slot, over=True))
    lines.remind()
    assert stream.getvalue() == before
    lines.close()
