"""How long a run still takes, against runs whose length is known because they are made up."""

from __future__ import annotations

import statistics

import pytest

from monitor.simulation import simulate
from robomore.monitor.remaining import CLOSING, makespan
from robomore.settings import preset, with_method

CASES = {
    "quick": preset("quick"),
    "standard": preset("standard"),
    "random": with_method(preset("quick"), "random"),
}
QUARTERS = (0.25, 0.5, 0.75)
SEEDS = range(6)


def estimated(told: list[tuple[float, float | None]], at: float) -> float | None:
    """Return the estimate that stood at some time."""
    return [left for time, left in told if time <= at][-1]


@pytest.mark.parametrize("failing", [0.0, 0.1])
@pytest.mark.parametrize("workers", [2, 8])
@pytest.mark.parametrize("name", CASES)
def test_the_estimate_is_near_the_truth(name: str, workers: int, failing: float) -> None:
    found = []
    for seed in SEEDS:
        total, told = simulate(CASES[name], workers, seed, failing)
        for share in QUARTERS:
            left = estimated(told, share * total)
            assert left is not None
            found.append(left / ((1 - share) * total))
    # How long the fine stage lasts is luck: with 30 seeds, 71 to 79 % and 89 to 93 % at `standard`.
    for factor, share in ((1.5, 0.7), (2.0, 0.85)):
        near = [1 / factor < ratio < factor for ratio in found]
        assert sum(near) >= share * len(found), sorted(found)
    assert 0.8 < statistics.median(found) < 1.25


@pytest.mark.parametrize("workers", [2, 8])
def test_screening_is_estimated_right_at_every_quarter_of_its_stage(workers: int) -> None:
    """A rung's trainings are shorter than the next one's, and there are more of them."""
    settings = with_method(preset("standard"), None, {"max_cycles": 0})
    total, told = simulate(settings, workers, seed=3)
    for share in (0.1, 0.2, 0.3, 0.4):
        left = estimated(told, share * total)
        assert left is not None
        assert 1 / 1.3 < left / ((1 - share) * total) < 1.3


@pytest.mark.parametrize("workers", [2, 8])
def test_what_is_around_a_training_is_no_part_of_its_steps(workers: int) -> None:
    """The first rung's trainings are short, and here they are loaded longer than they train."""
    settings = with_method(preset("standard"), None, {"max_cycles": 0})
    total, told = simulate(settings, workers, seed=3, around=40.0)
    for share in (0.1, 0.2, 0.3, 0.4, 0.6, 0.8):
        left = estimated(told, share * total)
        assert left is not None
        assert 1 / 1.3 < left / ((1 - share) * total) < 1.3


@pytest.mark.parametrize("workers", [2, 8])
def test_what_only_the_first_trainings_take_is_not_expected_of_all(workers: int) -> None:
    """Compiling takes as long as a short training does."""
    settings = with_method(preset("quick"), "random")
    compiling = settings.candidate.steps / 500
    total, told = simulate(settings, workers, seed=2, compiling=3 * compiling)
    first = next(left for _, left in told if left is not None)
    began = next(time for time, left in told if left is not None)
    assert 1 / 1.5 < first / (total - began) < 1.5


def test_the_estimate_follows_a_machine_that_others_use_too() -> None:
    settings = with_method(preset("quick"), "random")
    whole, _ = simulate(settings, 2, seed=2)
    total, told = simulate(settings, 2, seed=2, slower=4.0, slower_from=0.3 * whole)
    for share in (0.5, 0.7, 0.9):
        left = estimated(told, share * total)
        assert left is not None
        assert 1 / 1.5 < left / ((1 - share) * total) < 1.5


def test_a_budget_caps_the_search_and_not_the_final() -> None:
    settings = preset("quick")
    budget = 6 * settings.candidate.steps
    total, told = simulate(settings, 2, seed=1, budget_steps=budget)
    whole, _ = simulate(settings, 2, seed=1)
    assert total < 0.8 * whole
    for share in QUARTERS:
        left = estimated(told, share * total)
        assert left is not None and 1 / 1.5 < left / ((1 - share) * total) < 1.5


def test_a_time_limit_caps_everything() -> None:
    total, told = simulate(preset("quick"), 2, seed=1, time_limit=300.0)
    assert total > 300.0, "what is made up knows of no limit"
    assert all(left <= max(300.0 - time, 90.0) + CLOSING for time, left in told if left is not None)
    assert max(left for time, left in told if left is not None) > 150.0


def test_nothing_is_said_before_something_is_measured() -> None:
    _, told = simulate(preset("quick"), 8, seed=0)
    assert [left for _, left in told[:3]] == [None] * 3
    assert sum(left is None for _, left in told) < len(told) / 4
    assert told[-1][1] == CLOSING, "only the page is left"


@pytest.mark.parametrize(
    ("running", "waiting", "workers", "end"),
    [
        ([], {}, 2, 0.0),
        ([5.0], {}, 4, 5.0),
        ([], {3.0: 3}, 2, 6.0),
        ([1.0, 4.0], {2.0: 2}, 2, 5.0),
        ([1.0], {2.0: 2}, 8, 2.0),
        ([], {3.0: 99_999}, 2, 150_000.0),
    ],
)
def test_the_first_free_worker_takes_the_next_one(
    running: list[float], waiting: dict[float, int], workers: int, end: float
) -> None:
    assert makespan(running, waiting, workers) == end
