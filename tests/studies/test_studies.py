"""Studies at their smoke preset, without training: cells are runs; tables and figures are told."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from pathlib import Path
from statistics import fmean

import pytest

import untrained  # noqa: F401  # makes its executor known
from robomore.errors import InputError, NothingTrained
from robomore.events import ignore
from robomore.runs import load_run
from robomore.search import METHODS
from robomore.studies import STUDIES, Results, Study, Table, run_study
from robomore.studies.execute import cells_of
from robomore.studies.presets import SCALES, scale
from robomore.studies.study import Cell

SOME = ("robomore", "slim-reference", "random")
OTHERS = ("ablation", "coarse-to-fine", "diversity", "heatmaps", "transfer")


def some(seeds: int = 1) -> tuple[Study, list[Cell]]:
    """Return the comparison with a few of its arms."""
    study = STUDIES.get("comparison")
    cells = cells_of(study, ["swimmer"], scale("smoke"), seeds)
    return study, [cell for cell in cells if cell.arm.name in SOME]


@pytest.fixture(scope="module")
def compared(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Results]:
    """A small comparison that was stopped after its first cell, and went on."""
    out = tmp_path_factory.mktemp("study")
    study, cells = some()
    run_study(study, cells[:1], out, executor="untrained")
    before = (out / cells[0].folder / "ledger.sqlite").stat().st_mtime_ns
    begun: list[str] = []

    def tell(index: int, cell: Cell):  # type: ignore[no-untyped-def]
        begun.append(cell.arm.name)
        return ignore

    results = run_study(study, cells, out, executor="untrained", tell=tell)
    assert begun == [cell.arm.name for cell in cells]
    after = (out / cells[0].folder / "ledger.sqlite").stat().st_mtime_ns
    assert after == before, "a cell that was done ran again"
    return out, results


def table(out: Path, name: str) -> list[list[str]]:
    return list(csv.reader(io.StringIO((out / "tables" / f"{name}.csv").read_text())))


def test_the_comparison_has_every_method() -> None:
    arms = [cell.arm.name for cell in cells_of(STUDIES.get("comparison"), [], scale("smoke"), 1)]
    assert arms == [name for name in METHODS if name != "given"] * 2


def test_a_cell_is_an_ordinary_run_within_the_budget(compared: tuple[Path, Results]) -> None:
    out, results = compared
    for cell, run in results.cells:
        shown = load_run(out / cell.folder)
        assert shown.final and shown.manifest.settings == cell.settings
        assert run.search_steps <= cell.budget_steps


def test_tables_tell_what_was_found_and_over_what(compared: tuple[Path, Results]) -> None:
    out, results = compared
    head, *rows = table(out, "found")
    named = {row[1]: dict(zip(head, row, strict=True)) for row in rows}
    assert set(named) == {*SOME, "(human design)"}
    found = {arm: results.runs("swimmer", arm)[0].found.efficiency.mean for arm in SOME}
    assert {arm: float(named[arm]["mean (m/m³)"]) for arm in SOME} == found
    human = fmean(run.reference.efficiency.mean for run in results.runs())
    assert float(named["(human design)"]["mean (m/m³)"]) == pytest.approx(human)
    by_arm = {row[0]: row for row in table(out, "over-slim")[1:]}
    assert float(by_arm["random"][1]) == pytest.approx(found["random"] / found["slim-reference"])
    assert by_arm["random"][2] == "", "one run of each gives no interval"
    assert float(by_arm["random"][5]) == (found["random"] > found["slim-reference"])
    assert float(table(out, "over-human")[1][1]) == pytest.approx(found["robomore"] / human)


def test_figures_are_drawn(compared: tuple[Path, Results]) -> None:
    for name in ("curves-swimmer", "iqm"):
        for ending in ("svg", "pdf", "png"):
            assert (compared[0] / "figures" / f"{name}.{ending}").stat().st_size > 1000


@pytest.mark.parametrize("name", OTHERS)
def test_every_study_tells_of_its_arms(name: str, compared: tuple[Path, Results]) -> None:
    """The runs are those of the comparison, under the names of this study's arms."""
    study = STUDIES.get(name)
    whole, _, drawn = compared[1].cells
    cells = [
        (replace(whole[0], arm=arm), drawn[1] if arm.name == "random" else whole[1])
        for arm in study.arms
    ]
    results = Results(tuple(cells))
    for told in study.tables(results):
        assert {arm.name for arm in study.arms} <= {row[1] for row in told.rows} | {
            row[0] for row in told.rows
        } or name == "transfer"
        assert all(len(row) == len(told.columns) for row in told.rows)
    for draw in study.figures(results).values():
        assert draw(None).figure is not None
    if name == "diversity":
        rows = {row[1]: row for row in study.tables(results)[0].rows}
        # Random morphologies share one reward, so nothing can be said about its words.
        assert rows["random"][5] is None and rows["with-diversity"][4] > 0
    if name == "transfer":
        (told,) = study.tables(results)
        assert [row[2] for row in told.rows] == [
            getattr(whole[1], group).efficiency.mean
            for group in ("found", "morphology_only", "reward_only", "reference")
        ]


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", ["comparison", *OTHERS])
def test_every_study_runs_at_its_smoke_preset(name: str, tmp_path: Path) -> None:
    study = STUDIES.get(name)
    cells = cells_of(study, ["swimmer"], scale("smoke"), 2)
    results = run_study(study, cells, tmp_path, executor="untrained")
    assert len(results.cells) == len(cells)


def test_a_run_that_found_nothing_is_left_out_and_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compared: tuple[Path, Results]
) -> None:
    study, cells = some()
    out, _ = compared

    def nothing(*arguments: object, **options: object) -> None:
        raise NothingTrained("all failed")

    monkeypatch.setattr("robomore.studies.execute.run", nothing)
    monkeypatch.setattr("robomore.studies.execute._finished", lambda cell, folder: None)
    monkeypatch.setattr(
        "robomore.studies.execute.load_run",
        lambda folder: replace(load_run(out / cells[0].folder), found=None, reference=None),
    )
    run_study(study, cells[:1], tmp_path)
    found = table(tmp_path, "found")
    assert found[1][2] == "" and found[1][7] == "0 of 1"


def test_a_table_is_markdown_latex_and_csv() -> None:
    rows = (("a_b | 50 %", 12345.678), ("c", None))
    one = Table("t", "A title", ("arm", "m/m³"), rows, "Note.")
    assert "| a_b / 50 % | 12,350 |" in one.markdown() and "| c | - |" in one.markdown()
    assert r"a\_b | 50 \% & 12,350 \\" in one.latex() and r"arm & m/m$^3$ \\" in one.latex()
    assert one.csv().splitlines() == ["arm,m/m³", "a_b | 50 %,12345.678", "c,"]


def test_all_arms_of_a_study_have_one_budget_and_a_folder_each() -> None:
    for name in SCALES:
        for study in map(STUDIES.get, STUDIES):
            cells = cells_of(study, ["swimmer"], scale(name), 1)
            assert len({cell.budget_steps for cell in cells}) == 1
            assert len({cell.folder for cell in cells}) == len(cells)
            assert len({json.dumps(cell.arm.options) for cell in cells}) == len(cells)


def test_an_arm_that_changes_nothing_is_left_out() -> None:
    for name, screens in (("quick", False), ("standard", True)):
        cells = cells_of(STUDIES.get("ablation"), [], scale(name), 1)
        assert ("without-screening" in {cell.arm.name for cell in cells}) == screens


def test_what_cannot_be_studied_is_refused() -> None:
    with pytest.raises(InputError, match="--seeds is 0"):
        cells_of(STUDIES.get("comparison"), [], scale("smoke"), 0)
    with pytest.raises(InputError, match="swimer"):
        cells_of(STUDIES.get("comparison"), ["swimer"], scale("smoke"), 1)
    with pytest.raises(InputError, match="no preset is called 'fast'"):
        scale("fast")
    with pytest.raises(InputError, match="no study"):
        STUDIES.get("comparsion")
