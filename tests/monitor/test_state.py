"""What is known of a run from its events, whatever its stages are called."""

from __future__ import annotations

from dataclasses import replace

import pytest

from monitor.told import (
    BEGAN,
    GRID,
    LAST,
    SETTINGS,
    Clock,
    clock,
    failed,
    measured,
    state,
)
from robomore.events import BatchBegan, Finished, Progressed, Started
from robomore.monitor import RunState
from robomore.monitor.remaining import CLOSING
from robomore.plan import Plan, Stage
from robomore.types import Place

__all__ = ["clock", "state"]


def test_counts_and_best(state: RunState) -> None:
    assert (state.asked, state.done, state.failed) == (4, 2, 1)
    assert list(state.open) == [GRID[1], GRID[3]]
    assert list(state.running) == ["b"]
    assert state.best is not None and state.best[1] == GRID[0]
    assert state.trouble.startswith("reward-failed: line 3")
    state(Finished(measured("d", 2.0), GRID[3], known=False))
    assert state.best[1] == GRID[0]
    state(Finished(measured("b", 4.0), GRID[1], known=False))
    assert state.best[1] == GRID[1]


def test_what_screening_looked_at_is_not_the_best_of_the_search(state: RunState) -> None:
    look = Place(stage="looks", index=(0,))
    state(Finished(measured("x", 99.0), look, known=False))
    state(Finished(measured("y", 99.0, steps=200), GRID[3], known=False))
    assert state.best is not None and state.best[0].key == "a"


def test_the_final_is_not_the_best_of_the_search(state: RunState) -> None:
    state(BatchBegan(LAST, known=0))
    state(Finished(measured("z", 99.0), LAST[0], known=False))
    assert state.best is not None and state.best[0].key == "a"


def test_the_best_follows_the_objective(clock: Clock) -> None:
    state = RunState(clock)
    state(replace(BEGAN, settings=replace(SETTINGS, objective="fitness")))
    state(BatchBegan(GRID, known=0))
    state(Finished(replace(measured("a", 3.0), efficiency=1.0), GRID[0], known=False))
    state(Finished(replace(measured("b", 2.0), efficiency=9.0), GRID[1], known=False))
    assert state.best is not None and state.best[0].key == "a"


def test_the_time_left_counts_this_batch_the_later_stages_and_the_final(state: RunState) -> None:
    # 1,000 steps took 10 s of a worker: 1/100 s a step; the other worker's first training compiled
    # until it told of its progress, which is not counted. Of this batch a half and a whole
    # training are left, side by side. Then two batches of one training, and the final: four
    # trainings of 2,000 steps for two workers, at whose end one waits, half a training on average.
    left = state.time_left()
    assert left == pytest.approx((1_000 + 2 * 1_000 + 2 * 2_000 + 500) / 100 + CLOSING)


def test_a_training_that_goes_on_counts_for_what_is_left_of_it(clock: Clock) -> None:
    state = RunState(clock)
    state(BEGAN)
    for place in GRID:
        state(Finished(measured("a", 1.0, steps=400), place, known=True))
    state(BatchBegan(GRID[:1], known=0))
    state(Started("b", GRID[0], 1_000))
    clock.now += 6
    state(Progressed("b", 700))
    running = state.running["b"]
    assert (running.before, running.steps) == (400, 700)
    state(Finished(measured("b", 1.0), GRID[0], known=False))
    clock.now += 100
    state(BatchBegan(LAST, known=0))
    # 600 steps took 6 s; the final asks for two trainings of two workers.
    assert state.time_left() == pytest.approx(1_000 / 100 + CLOSING)


def test_what_was_known_before_says_nothing_of_speed(clock: Clock) -> None:
    state = RunState(clock)
    state(BEGAN)
    state(BatchBegan(GRID, known=4))
    for place in GRID:
        state(Finished(measured("a", 1.0), place, known=True))
    assert state.known == 4
    assert state.time_left() is None


def test_a_failure_says_nothing_of_speed(clock: Clock) -> None:
    state = RunState(clock)
    state(BEGAN)
    state(BatchBegan(GRID, known=0))
    state(Started("c", GRID[2], 1_000))
    clock.now += 1
    state(Finished(failed("c"), GRID[2], known=False))
    assert state.time_left() is None


def test_a_stage_in_batches_is_counted_as_a_whole(clock: Clock) -> None:
    state = RunState(clock)
    grown = Stage(name="generations", evaluations=6, batches=3)
    state(replace(BEGAN, plan=Plan((grown, *BEGAN.plan.stages))))
    places = [Place(stage="generations", index=(i,)) for i in range(6)]
    counts = []
    for first in (0, 2):
        state(BatchBegan(tuple(places[first : first + 2]), known=0))
        for place in places[first : first + 2]:
            state(Finished(measured(f"k{place.index[0]}", 1.0), place, known=False))
            counts.append((state.done, state.asked, state.batch))
    assert counts == [(1, 6, 2), (2, 6, 2), (3, 6, 2), (4, 6, 2)]
    state(BatchBegan(GRID, known=0))
    assert (state.done, state.asked) == (0, 4)
