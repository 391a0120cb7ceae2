"""The page that compares runs: all numbers of a row are of the same design."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from fake_run import FOUND_FITNESS, SETTINGS, FakeRun, finished_run
from robomore.errors import InputError
from robomore.report.comparison import _line, _rows, render_comparison, write_comparison
from robomore.report.run_groups import run_groups
from robomore.runs import Run, load_run
from robomore.statistics.spread import spread
from robomore.types import Design, Place, Status


def test_a_method_s_row_is_of_what_its_searches_found(tmp_path: Path) -> None:
    fake = FakeRun(tmp_path)
    best = fake.coarse()
    fake.final(best, champion="reward_only")
    run = load_run(tmp_path)
    assert run.champion_role == "reward_only"
    assert run.champion and run.found and run.found.efficiency
    assert run.reference and run.reference.efficiency
    (row,) = _rows(run_groups([run]))
    mean = sum(FOUND_FITNESS) / len(FOUND_FITNESS)
    assert row["fitness"].mean == pytest.approx(mean)
    assert row["volume"] == pytest.approx(run.found.volume) != run.champion.volume
    assert row["found"].mean == pytest.approx(mean / row["volume"])
    assert row["ratio"].mean == pytest.approx(
        run.found.efficiency.mean / run.reference.efficiency.mean
    )
    page = render_comparison([run])
    assert "found over reference" in page and "of the designs that the searches found" in page


def small_run(path: Path, fitness: float | None, seed: int = 0, **changed: object) -> Run:
    """Write a run whose search trained one design; `None` for one in which nothing trained."""
    fake = FakeRun(path, settings=replace(SETTINGS, **changed))  # type: ignore[arg-type]
    design = Design(fake.morphology(0.5), fake.reward(1.0))
    ended = () if fitness is not None else (Status.TIMED_OUT, "slow")
    best = fake.add(design, Place(stage="coarse", index=(0, 0)), fitness, *ended)
    if fitness is not None:
        fake.final(best)
    run = load_run(path)
    return replace(run, manifest=replace(run.manifest, seed=seed))


def words(page: str) -> str:
    return " ".join(re.sub("<[^>]+>", " ", page).split())


def test_metres_and_metres_per_volume_have_no_mean_in_common(tmp_path: Path) -> None:
    one = small_run(tmp_path / "one", 10.0)
    same = small_run(tmp_path / "same", 10.0, seed=1)
    other = small_run(tmp_path / "other", 10.0, objective="fitness")
    groups = run_groups([one, other, same])
    assert [len(group.runs) for group in groups] == [2, 1]
    assert [group.objective for group in groups] == ["efficiency", "fitness"]
    assert groups[0].kind != groups[1].kind and groups[0].name != groups[1].name
    page = words(render_comparison([one, other, same]))
    assert "Swimmer: efficiency (m/m³)" in page and "Swimmer: fitness (m)" in page
    assert "13.00 m " in page


def test_runs_of_another_size_or_budget_are_other_rows(tmp_path: Path) -> None:
    whole = small_run(tmp_path / "whole", 10.0)
    larger = replace(whole, budget_steps=7_000)
    smoke = replace(whole, manifest=replace(whole.manifest, preset="smoke"))
    groups = run_groups([whole, larger])
    assert [group.name for group in groups] == [
        "robomore, offline, preset quick",
        "robomore, offline, preset quick, with budget steps 7,000",
    ]
    # The same settings under two names are the same.
    assert len(run_groups([whole, smoke])) == 1
    models = [
        replace(whole, manifest=replace(whole.manifest, designer_settings={"model": name}))
        for name in ("ollama:a", "ollama:b")
    ]
    assert [group.name for group in run_groups(models)] == [
        "robomore, offline, ollama:a",
        "robomore, offline, ollama:b",
    ]


def test_a_band_is_what_it_is_called(tmp_path: Path) -> None:
    values = (1.0, 2.0, 3.0, 4.0, 100.0)
    runs = [small_run(tmp_path / str(n), value, seed=n) for n, value in enumerate(values)]
    (group,) = run_groups(runs)
    scores = [run.searched[0].evaluation.efficiency for run in runs]
    assert all(scores)
    interval = spread([score for score in scores if score]).interval
    assert interval is not None
    _, low, _, high = _line(group)[-1]
    assert (low, high) == pytest.approx(interval)
    assert "band: 95 % interval of the mean over 5 runs" in words(render_comparison(runs))
    few = words(render_comparison(runs[:3]))
    assert "band: least to largest of 3 runs" in few and "95 % interval of the mean" not in few


def test_runs_in_which_nothing_trained_are_not_counted_in_means(tmp_path: Path) -> None:
    runs = [small_run(tmp_path / str(n), value, n) for n, value in enumerate((10.0, 12.0, None))]
    (row,) = _rows(run_groups(runs))
    assert (row["counted"], row["runs"]) == (2, 3)
    page = render_comparison(runs)
    assert ">2 of 3</td>" in page and "mean of 2 of 3 runs" in page
    assert "band: least to largest of 2 of 3 runs" in words(page)


def test_a_folder_without_a_run_is_named(tmp_path: Path) -> None:
    finished_run(tmp_path / "run")
    with pytest.raises(InputError, match=r"no run in .*no-such-run"):
        write_comparison([tmp_path / "run", tmp_path / "no-such-run"], tmp_path / "page.html")
    assert not (tmp_path / "page.html").exists()
