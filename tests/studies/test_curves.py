"""Curves of the best so far: what is measured again for them, and which runs they leave out."""

from __future__ import annotations

import logging
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

import untrained  # noqa: F401  # makes its executor known
from fake_run import FakeRun, finished_run
from robomore.errors import InputError, Interrupted
from robomore.evaluation.measure import measure
from robomore.identity import derive_seed
from robomore.runs import Run, load_run
from robomore.runs.progress import progress
from robomore.search.robomore.branch import REPEAT
from robomore.studies import STUDIES, Cell, Results, run_study
from robomore.studies.execute import cells_of
from robomore.studies.presets import scale
from robomore.studies.remeasured import LEAST_EPISODES, Remeasured, incumbents
from robomore.studies.scores import curve_figures
from robomore.types import Design, Place

MEASURE = "robomore.studies.remeasured.measure"


def one_arm(study: str, arm: str) -> list[Cell]:
    cells = cells_of(STUDIES.get(study), ["swimmer"], scale("smoke"), 1)
    return [cell for cell in cells if cell.arm.name == arm]


def results_of(*runs: Run, again: dict[str, float]) -> Results:
    """Return runs of one arm."""
    cells = [
        SimpleNamespace(task="swimmer", seed=seed, arm=SimpleNamespace(name="robomore"))
        for seed in range(len(runs))
    ]
    return Results(tuple((cast(Any, c), run) for c, run in zip(cells, runs, strict=True)), again)


def test_the_best_so_far_is_measured_again(
    trained_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = load_run(trained_run)
    expected = {point.record.evaluation.key for point in incumbents(run)}
    again, counts = Remeasured(tmp_path), list[int]()
    again.add(run, counts.append)
    assert set(again.scores) == expected and counts == [len(expected)]
    first = incumbents(run)[0].record.evaluation
    assert again.scores[first.key] != first.efficiency
    task, parameters = run.task, first.design.morphology.parameters
    apart = derive_seed(first.job.seed, "measured again")
    episodes = max(LEAST_EPISODES, first.job.episodes)
    found = measure(task, parameters, run.load_policy(first.key), episodes, apart)
    assert again.scores[first.key] == pytest.approx(found.fitness / task.volume(parameters))
    monkeypatch.setattr(MEASURE, None)
    known = Remeasured(tmp_path)
    known.add(run, counts.append)
    assert known.scores == again.scores and len(counts) == 1, "what is known is read"
    (line, *_) = curve_figures(results_of(run, again=known.scores))["curves-swimmer"](None).lines
    assert line.get_ydata()[0] == again.scores[first.key]
    (tmp_path / "remeasured.json").write_text("[")
    with pytest.raises(InputError, match="cannot be read"):
        Remeasured(tmp_path)


def test_a_second_seed_of_the_best_is_in_the_curve_too(tmp_path: Path) -> None:
    fake = FakeRun(tmp_path)
    ahead = Design(fake.morphology(0.5), fake.reward(1.0))
    behind = Design(fake.morphology(0.5), fake.reward(2.0))
    place = Place(stage="fine", index=(0, 0), changed="reward")
    one = fake.add(ahead, place, 10.0)
    two = fake.add(ahead, replace(place, repeat=REPEAT), 6.0)
    three = fake.add(behind, replace(place, index=(0, 1)), 9.0)
    run = load_run(tmp_path)
    assert [[e.key for e in point.leader] for point in incumbents(run)] == [
        [one.key],
        [one.key, two.key],
        [three.key],
    ]
    again = {one.key: 4.0, two.key: 2.0, three.key: 7.0}
    (line, *_) = curve_figures(results_of(run, again=again))["curves-swimmer"](None).lines
    assert list(dict.fromkeys(line.get_ydata())) == [4.0, 3.0, 7.0]


def test_a_run_that_cannot_be_measured_again_is_left_out_and_named(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    whole, lost = (load_run(finished_run(tmp_path / name).path) for name in ("whole", "lost"))
    known = {e.key: 5.0 for point in incumbents(whole) for e in point.leader}
    # The same keys in both runs, so the other one has to lack one of its own.
    missing = replace(lost.records[0].evaluation, key="other")
    lost = replace(lost, records=(replace(lost.records[0], evaluation=missing), *lost.records[1:]))
    axes = curve_figures(results_of(whole, lost, again=known))["curves-swimmer"](None)
    assert axes.get_title("left") == "left out, not measured again: lost"
    (line, *_) = axes.lines
    assert line.get_label() == "robomore (1 of 2 runs)" and set(line.get_ydata()) == {5.0}
    assert curve_figures(results_of(lost, again=known)) == {}
    assert progress(lost)[0].score != 5.0, "what the search saw is no substitute"
    again = Remeasured(tmp_path)
    with caplog.at_level(logging.WARNING):
        again.add(lost)
    assert "lost is left out of the curves: other, " in caplog.text and again.scores == {}


def test_nothing_is_measured_again_where_no_curve_is_drawn(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[object] = []

    def measured(*arguments: object) -> object:
        calls.append(arguments)
        return SimpleNamespace(fitness=1.0, behaviour={})

    monkeypatch.setattr(MEASURE, measured)
    run_study(
        STUDIES.get("transfer"),
        one_arm("transfer", "robomore"),
        tmp_path / "a",
        executor="untrained",
    )
    assert not calls and not (tmp_path / "a" / "remeasured.json").exists()
    with monkeypatch.context() as patch:
        patch.setattr("robomore.studies.execute._pyplot", lambda: None)
        comparison = STUDIES.get("comparison")
        cells = one_arm("comparison", "random")
        run_study(comparison, cells, tmp_path / "b", executor="untrained")
    assert not calls
    run_study(comparison, cells, tmp_path / "b", executor="untrained")
    assert calls, "the comparison draws curves"


def test_measuring_again_can_be_stopped_and_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stopped(*arguments: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(MEASURE, stopped)
    cells, told = one_arm("comparison", "random"), list[tuple[int, str, int]]()
    with pytest.raises(Interrupted, match=r"stopped; 0 of 1 runs are done .*same command"):
        run_study(
            STUDIES.get("comparison"),
            cells,
            tmp_path,
            executor="untrained",
            measuring=lambda index, cell, count: told.append((index, cell.arm.name, count)),
        )
    assert [one[:2] for one in told] == [(0, "random")] and told[0][2] >= 1


def test_studies_that_draw_curves_say_so() -> None:
    drawing = [name for name in STUDIES if STUDIES.get(name).curves]
    assert drawing == ["comparison", "ablation", "coarse-to-fine"]
