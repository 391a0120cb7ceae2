"""Arms over a base, on finals with numbers that a test knows."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from robomore.runs import Run
from robomore.statistics import interquartile_mean, stratified_interval
from robomore.studies.aggregate import aggregate_table, interval_figure, interval_over, over
from robomore.studies.scores import found_table
from robomore.studies.study import Results, SeedScores


def runs_of(*tasks: list[float]) -> list[list[SeedScores]]:
    """Return one run of each number, each with trainings of its own."""
    return [[SeedScores(seed, (one,)) for seed, one in enumerate(task)] for task in tasks]


def trained(seeds: list[float | None], key: str) -> Any:
    """Return a design with a number for each training, `None` for one that failed."""
    ends = [
        SimpleNamespace(key=f"{key}-{n}", score=lambda objective, one=one: one)
        for n, one in enumerate(seeds)
    ]
    known = [one for one in seeds if one is not None]
    mean = SimpleNamespace(mean=sum(known) / len(known)) if known else None
    return SimpleNamespace(
        evaluations=tuple(ends),
        trained=tuple(known),
        score=lambda objective: mean,
        fitness=mean,
        volume=1.0,
    )


def results(**arms: list[list[float | None] | None]) -> Results:
    """Return runs of arms: of each the numbers of its answer's trainings; `None` without one."""
    cells = []
    for arm, runs in arms.items():
        for seed, one in enumerate(runs):
            cell = SimpleNamespace(task="swimmer", seed=seed, arm=SimpleNamespace(name=arm))
            run = SimpleNamespace(
                found=None if one is None else trained(one, f"{arm}-{seed}"),
                reference=None,
                objective="efficiency",
                fitness_unit="m",
                search_steps=10,
                cost=SimpleNamespace(core_seconds=1.0),
            )
            cells.append((cast(Any, cell), cast(Run, run)))
    return Results(tuple(cells))


def row(told: Results, arm: str, base: str = "base") -> dict[str, Any]:
    table = aggregate_table(told, "over", base, {"swimmer": told.answers("swimmer", base)})
    return dict(zip(table.columns, next(r for r in table.rows if r[0] == arm), strict=True))


def test_the_interval_over_a_base_knows_that_the_base_was_measured_too() -> None:
    runs = [[2.0, 3.0, 4.0, 5.0, 6.0], [20.0, 30.0, 40.0, 50.0, 60.0]]
    exact = [[2.0] * 5, [20.0] * 5]
    noisy = [[1.0, 1.5, 2.0, 2.5, 3.0], [10.0, 15.0, 20.0, 25.0, 30.0]]
    fixed = stratified_interval(interquartile_mean, over(runs, exact))
    assert interval_over(runs_of(*runs), runs_of(*exact)) == pytest.approx(fixed)
    wider = interval_over(runs_of(*runs), runs_of(*noisy))
    assert wider and wider[0] < fixed[0] and wider[1] > fixed[1]
    few = runs_of([1.0] * 4, [1.0] * 5)
    assert interval_over(runs_of(*runs), few) is None, "four runs are no base"
    assert interval_over(runs_of(*runs), runs_of([0.0] * 5, [1.0] * 5)) is None


def test_trainings_that_both_sides_have_are_drawn_once() -> None:
    """The human design at `standard`: an arm of five means, over the same 15 trainings."""
    measured = np.random.default_rng(3).lognormal(0, 0.6, (5, 3))
    keys = [frozenset(f"{seed}-{n}" for n in range(3)) for seed in range(5)]
    arm = [SeedScores(s, (float(measured[s].mean()),), keys[s]) for s in range(5)]
    base = [SeedScores(s, tuple(map(float, measured[s])), keys[s]) for s in range(5)]
    random = np.random.default_rng(0)
    drawn = [measured[random.integers(5, size=5)] for _ in range(2000)]
    once = [interquartile_mean([one.mean(axis=1)]) / one.mean() for one in drawn]
    together = interval_over([arm], [base])
    assert together == pytest.approx(np.percentile(once, [2.5, 97.5]), rel=0.05)
    apart = interval_over([[SeedScores(one.seed, one.values) for one in arm]], [base])
    assert together and apart and apart[1] - apart[0] > 2 * (together[1] - together[0])
    # The seeds differ, so they cannot be drawn together.
    other = [SeedScores(one.seed + 1, one.values, one.trainings) for one in arm]
    assert interval_over([other], [base]) == apart


def test_a_run_without_an_answer_loses_and_is_counted() -> None:
    told = results(base=[[1.0], [2.0], [3.0], [4.0], None], lucky=[[9.0], None, None, None, None])
    found = row(told, "lucky")
    assert found["runs"] == "1 of 5" and row(told, "base")["runs"] == "4 of 5"
    # The lucky one wins all five; the others tie with the one of the base that failed.
    assert found["P(beats base)"] == pytest.approx((5 + 4 * 0.5) / 25)
    assert found["IQM (over the mean of base)"] == pytest.approx(9.0 / 2.5)
    nothing = row(results(base=[[-1.0], [4.0]], none=[None, None]), "none")
    assert nothing["P(beats base)"] == 0 and nothing["runs"] == "0 of 2"
    assert nothing["IQM (over the mean of base)"] is None


def test_final_trainings_that_failed_are_told() -> None:
    told = found_table(results(arm=[[None, 3.0, None], [1.0, 2.0, 3.0], [None] * 3, None]))
    found = dict(zip(told.columns, told.rows[0], strict=True))
    assert found["runs"] == "2 of 4" and found["failed final trainings"] == "5 of 9"
    assert found["mean (m/m³)"] == pytest.approx(2.5)
    assert all(len(row) == len(told.columns) for row in told.rows)


def test_what_is_divided_by_is_named_and_a_base_need_not_be_at_one() -> None:
    told = results(base=[[1.0], [2.0], [3.0], [4.0], [100.0]])
    found = row(told, "base")
    assert found["IQM (over the mean of base)"] == pytest.approx(3 / 22)
    assert found["mean (over the mean of base)"] == pytest.approx(1.0)
    bases = {"swimmer": told.answers("swimmer", "base")}
    table = aggregate_table(told, "over", "base", bases)
    assert table.title.startswith("All tasks together, over the mean of base: ")
    assert "need not be 1" in table.note
    axes = interval_figure(told, bases, "base")["iqm"](None)
    assert axes.get_xlabel() == "IQM over the mean of base"
    (line,) = [one for one in axes.lines if list(one.get_xdata()) == [1, 1]]
    assert line.get_label() == "mean of base" and axes.get_legend() is not None
