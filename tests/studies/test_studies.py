"""Studies at their smoke preset, without training: cells are runs; tables and figures are told."""

from __future__ import annotations

import csv
import io
import json
import shutil
from dataclasses import replace
from pathlib import Path
from statistics import fmean
from types import SimpleNamespace

import pytest

import untrained  # noqa: F401  # makes its executor known
from robomore.errors import InputError, Interrupted, NothingTrained, RunFolderError
from robomore.events import ignore
from robomore.plain_files import NotPlainError
from robomore.rewards.check import check_reward
from robomore.runs import Run, load_run
from robomore.search import METHODS
from robomore.search.named_starts import named_start
from robomore.store import Manifest, RunFolder
from robomore.studies import STUDIES, Results, Study, Table, run_study
from robomore.studies.aggregate import aggregate_table
from robomore.studies.execute import cells_of, write_results
from robomore.studies.presets import SCALES, scale
from robomore.studies.scores import found_table
from robomore.studies.study import Arm, Cell, SeedScores
from robomore.tasks import get_task
from robomore.tasks.registry import PAPER_TASKS

SOME = ("robomore", "slim-reference", "random")
WITH_TASKS = ("motivation", "robustness-gear", "robustness-terrain")
"""Studies that are about tasks of their own."""
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
    begun: list[str] = []

    def tell(index: int, cell: Cell):  # type: ignore[no-untyped-def]
        begun.append(cell.arm.name)
        return ignore

    with pytest.MonkeyPatch.context() as patch:
        measured = SimpleNamespace(fitness=1.0, behaviour={})
        patch.setattr("robomore.studies.remeasured.measure", lambda *arguments: measured)
        run_study(study, cells[:1], out, executor="untrained")
        before = (out / cells[0].folder / "ledger.sqlite").stat().st_mtime_ns
        results = run_study(study, cells, out, executor="untrained", tell=tell)
    assert begun == [cell.arm.name for cell in cells]
    after = (out / cells[0].folder / "ledger.sqlite").stat().st_mtime_ns
    assert after == before, "a cell that was done ran again"
    return out, results


def table(out: Path, name: str) -> list[list[str]]:
    return list(csv.reader(io.StringIO((out / "tables" / f"{name}.csv").read_text())))


def test_the_comparison_has_every_method() -> None:
    arms = [cell.arm.name for cell in cells_of(STUDIES.get("comparison"), [], scale("smoke"), 1)]
    own = [name for name in METHODS if name != "given"]
    begun = [f"{name}-from-slim-reference" for name in ("bayesian", "cmaes", "eureka-morphology")]
    # The preset `smoke` is without the slim reference as it is.
    assert arms == [*own, *begun] * 2
    arms = [cell.arm.name for cell in cells_of(STUDIES.get("comparison"), [], scale("quick"), 1)]
    assert arms == [*own, "robomore-from-nothing", *begun] * 2


def test_an_arm_starts_from_what_it_says_and_another_start_is_another_run(tmp_path: Path) -> None:
    arms = (Arm("plain"), Arm("slim", start_from=("slim-reference",)))
    study = Study("starts", "", arms, lambda results: [])
    cells = cells_of(study, ["swimmer"], scale("smoke"), 1)
    results = run_study(study, cells, tmp_path, executor="untrained")
    slim = named_start(get_task("swimmer"), "slim-reference").morphology
    tried = {
        cell.arm.name: {one.design.morphology.parameters for one in run.evaluations}
        for cell, run in results.cells
    }
    assert slim and slim.parameters in tried["slim"] and slim.parameters not in tried["plain"]
    other = replace(cells[0], arm=replace(cells[0].arm, start_from=("reference",)))
    with pytest.raises(RunFolderError):
        run_study(study, [other], tmp_path, executor="untrained")


def test_a_cell_of_another_designer_or_version_is_not_taken_for_done(
    compared: tuple[Path, Results], tmp_path: Path
) -> None:
    study, cells = some()
    out = Path(shutil.copytree(compared[0], tmp_path / "study"))
    with pytest.raises(InputError, match="another"):
        run_study(study, cells, out, executor="untrained", designer="another")
    path = RunFolder(out / cells[0].folder).manifest
    manifest = Manifest.load(path)
    replace(manifest, versions={**manifest.versions, "robomore": "0.0.1"}).save(path)
    with pytest.raises(RunFolderError, match=r"robomore 0\.0\.1 there"):
        run_study(study, cells, out, executor="untrained")


@pytest.mark.parametrize("name", ["tables", "tables/found.md", "figures/iqm.svg"])
def test_nothing_is_written_through_a_link(
    name: str, compared: tuple[Path, Results], tmp_path: Path
) -> None:
    target = tmp_path / "of the user"
    target.mkdir() if name == "tables" else target.write_text("mine")
    link = tmp_path / "study" / name
    link.parent.mkdir(parents=True)
    link.symlink_to(target)
    with pytest.raises(NotPlainError, match="link"):
        write_results(STUDIES.get("comparison"), compared[1], tmp_path / "study")
    assert (list(target.iterdir()) == []) if name == "tables" else target.read_text() == "mine"


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


def test_no_base_gives_no_table_of_dashes(compared: tuple[Path, Results]) -> None:
    _, results = compared
    arm = results.arms[0]
    some_rows = aggregate_table(results, "over", arm, {"swimmer": [SeedScores(0, (1.0,))]})
    assert some_rows.rows and "IQM" in some_rows.markdown()
    without = aggregate_table(results, "over", arm, {"swimmer": [SeedScores(0, (-1.0,))]})
    assert without.markdown() == (
        f"**All tasks together, over the mean of {arm}: no task has a base above 0**\n"
    )
    nowhere = aggregate_table(results, "over", arm, {"ant": [SeedScores(0, (1.0,))]})
    assert "| " not in nowhere.markdown() and "No arm has a result" in nowhere.markdown()


def test_figures_are_drawn(compared: tuple[Path, Results]) -> None:
    for name in ("curves-swimmer", "iqm"):
        for ending in ("svg", "pdf", "png"):
            assert (compared[0] / "figures" / f"{name}.{ending}").stat().st_size > 1000


def test_a_call_with_other_arms_says_so_and_leaves_no_figure_of_other_runs(
    compared: tuple[Path, Results], tmp_path: Path
) -> None:
    out = Path(shutil.copytree(compared[0], tmp_path / "study"))
    (out / "figures" / "mine.png").write_text("of the user")
    study, cells = some()
    asked = [cell for cell in cells if cell.arm.name == "random"]
    results = run_study(study, asked, out, executor="untrained")
    told = (out / "tables" / "found.md").read_text()
    assert "This table covers only what its call named: random on swimmer. Left out are 2" in told
    assert "(swimmer-robomore-s0, swimmer-slim-reference-s0)" in told
    assert "covers only" in (out / "tables" / "over-human.tex").read_text()
    drawn = {f"{name}.svg" for name in study.figures(results)}
    assert "iqm.svg" not in drawn, "nothing to divide by"
    left = {path.name for path in (out / "figures").iterdir()}
    assert "mine.png" in left and {name for name in left if name.endswith(".svg")} == drawn
    run_study(study, cells, out, executor="untrained")
    assert "covers only" not in (out / "tables" / "found.md").read_text()
    assert (out / "figures" / "iqm.svg").is_file()


@pytest.mark.parametrize("name", OTHERS)
def test_every_study_tells_of_its_arms(name: str, compared: tuple[Path, Results]) -> None:
    """The runs are those of the comparison, under the names of this study's arms."""
    study = STUDIES.get(name)
    whole, *_ = compared[1].cells
    results = Results(tuple((replace(whole[0], arm=arm), whole[1]) for arm in study.arms))
    for told in study.tables(results):
        assert {arm.name for arm in study.arms} <= {row[1] for row in told.rows} | {
            row[0] for row in told.rows
        } or name == "transfer"
        assert all(len(row) == len(told.columns) for row in told.rows)
    for draw in study.figures(results).values():
        assert draw(None).figure is not None
    if name == "diversity":
        rows = {row[1]: row for row in study.tables(results)[0].rows}
        assert rows["random"][4] > 0 and rows["with-diversity"][4] > 0
    if name == "transfer":
        (told,) = study.tables(results)
        assert [row[2] for row in told.rows] == [
            getattr(whole[1], group).efficiency.mean
            for group in ("found", "morphology_only", "reward_only", "reference")
        ]


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", ["comparison", *OTHERS, *WITH_TASKS])
def test_every_study_runs_at_its_smoke_preset(name: str, tmp_path: Path) -> None:
    study = STUDIES.get(name)
    tasks = [] if name in WITH_TASKS else ["swimmer"]
    cells = cells_of(study, tasks, scale("smoke"), 2)
    results = run_study(study, cells, tmp_path, executor="untrained")
    assert len(results.cells) == len(cells)


def test_a_design_found_in_one_task_is_trained_in_the_others(tmp_path: Path) -> None:
    study = STUDIES.get("robustness-terrain")
    first, *others = cells_of(study, ["ant-snow"], scale("smoke"), 1)
    assert first.task == "ant-desert" and first.retrains is None
    assert [cell.retrains for cell in others] == [first]
    results = run_study(study, [first, *others], tmp_path, executor="untrained")
    searched, snow = results.runs()
    assert searched.found is not None and snow.found is not None
    assert snow.found.design.morphology.parameters == searched.found.design.morphology.parameters
    assert snow.found.design.reward.source == searched.found.design.reward.source
    assert snow.manifest.settings.method.name == "given" and len(snow.searched) == 1
    (told,) = study.tables(results)
    assert [row[0] for row in told.rows] == ["Ant-Desert", "Ant-Snow"]
    assert told.rows[1][1] == snow.found.efficiency.mean  # type: ignore[union-attr]
    for draw in study.figures(results).values():
        assert draw(None).figure is not None
    # The same command finishes what is missing, and repeats nothing.
    begun = (tmp_path / others[0].folder / "ledger.sqlite").stat().st_mtime_ns
    run_study(study, [first, *others], tmp_path, executor="untrained")
    assert (tmp_path / others[0].folder / "ledger.sqlite").stat().st_mtime_ns == begun
    with pytest.raises(InputError, match="leave its arm in the study"):
        run_study(study, others, tmp_path, executor="untrained")


def test_what_a_search_did_not_find_is_trained_nowhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    study = STUDIES.get("robustness-terrain")
    cells = cells_of(study, ["ant-snow"], scale("smoke"), 2)
    whole = run_study(study, cells, tmp_path, executor="untrained")
    known = {cell.folder: run for cell, run in whole.cells}
    lost = cells[0].folder
    known[lost] = replace(known[lost], found=None)
    monkeypatch.setattr(
        "robomore.studies.execute._finished", lambda cell, *about: known[cell.folder]
    )
    results = run_study(study, cells, tmp_path, executor="untrained")
    assert [cell.seed for cell, _ in results.cells] == [0, 1, 1], "the other seed is told"


def test_the_motivation_tells_its_four_cases(tmp_path: Path) -> None:
    study = STUDIES.get("motivation")
    cells = cells_of(study, [], scale("smoke"), 1)[:1]
    results = run_study(study, cells, tmp_path, executor="untrained")
    (told,) = study.tables(results)
    assert told.rows[0][0] == "short-rolling" and told.rows[0][4] == 108.83
    assert "rolling" in results.runs()[0].found.design.reward.source  # type: ignore[union-attr]
    # The paper's own volumes: fitness / efficiency; its two short cases do not agree.
    task = get_task("ant")
    for arm, legs in zip(study.arms[1:3], (108.83 / 288.76, 59.94 / 1457.65), strict=True):
        volume = task.volume(arm.options["method_options"]["parameters"])
        assert volume == pytest.approx(legs, rel=0.01)
        assert not check_reward(arm.options["method_options"]["reward"])


def test_a_run_that_found_nothing_is_left_out_and_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compared: tuple[Path, Results]
) -> None:
    study, cells = some()
    out, _ = compared

    def nothing(*arguments: object, **options: object) -> None:
        raise NothingTrained("all failed")

    monkeypatch.setattr("robomore.studies.execute.run", nothing)
    monkeypatch.setattr("robomore.studies.execute._finished", lambda *about: None)
    monkeypatch.setattr(
        "robomore.studies.execute.load_run",
        lambda folder: replace(load_run(out / cells[0].folder), found=None, reference=None),
    )
    run_study(study, cells[:1], tmp_path)
    found = table(tmp_path, "found")
    assert found[1][2:6] == [""] * 4 and found[1][10:12] == ["0 of 1", "0 of 0"]


def test_each_task_has_an_iqm_with_an_interval_from_five_runs_on(
    trained_run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cell, run = some()[1][0], load_run(trained_run)
    scores = [0.0, 10.0, 20.0, 30.0, 1000.0]
    monkeypatch.setattr(Results, "scores", lambda self, task, arm: scores)
    for interval in (True, False):
        row = found_table(Results(((cell, run),), {})).rows[0]
        assert row[3] == pytest.approx(20.0 if interval else 15.0)
        assert (row[4] is not None and row[5] is not None) == interval
        scores.pop()


def test_a_table_is_markdown_latex_and_csv() -> None:
    rows = (("a_b | 50 %", 12345.678), ("c", None))
    one = Table("t", "A title", ("arm", "m/m³"), rows, "Note.")
    assert "| a_b / 50 % | 12,350 |" in one.markdown() and "| c | - |" in one.markdown()
    assert r"a\_b | 50 \% & 12,350 \\" in one.latex() and r"arm & m/m$^3$ \\" in one.latex()
    assert one.csv().splitlines() == ["arm,m/m³", "a_b | 50 %,12345.678", "c,"]


def test_all_arms_of_a_study_have_one_budget_and_a_folder_each() -> None:
    for name in SCALES:
        for study in map(STUDIES.get, STUDIES):
            tasks = [] if study.name in WITH_TASKS else ["swimmer"]
            cells = cells_of(study, tasks, scale(name), 1)
            assert len({cell.budget_steps for cell in cells}) == 1
            assert len({cell.folder for cell in cells}) == len(cells)
            assert len(
                {(c.task, json.dumps(c.arm.options), c.arm.start_from) for c in cells}
            ) == len(cells)


def test_an_arm_that_changes_nothing_is_left_out() -> None:
    for name, screens in (("quick", False), ("standard", True)):
        cells = cells_of(STUDIES.get("ablation"), [], scale(name), 1)
        assert ("without-screening" in {cell.arm.name for cell in cells}) == screens


def test_what_cannot_be_studied_is_refused() -> None:
    with pytest.raises(InputError, match="--seeds is 0"):
        cells_of(STUDIES.get("comparison"), [], scale("smoke"), 0)
    with pytest.raises(InputError, match="swimer"):
        cells_of(STUDIES.get("comparison"), ["swimer"], scale("smoke"), 1)
    with pytest.raises(InputError, match="swimmer has other parameters; choose tasks of the same"):
        cells_of(STUDIES.get("robustness-gear"), ["swimmer"], scale("smoke"), 1)
    with pytest.raises(InputError, match="has its own robots, for ant; leave ant-desert out"):
        cells_of(STUDIES.get("motivation"), ["ant-desert"], scale("smoke"), 1)
    with pytest.raises(InputError, match="no preset is called 'fast'"):
        scale("fast")
    with pytest.raises(InputError, match="no study"):
        STUDIES.get("comparsion")


def test_the_costs_of_the_paper_are_told_as_they_are() -> None:
    page = (Path(__file__).parents[2] / "docs" / "reproduce.md").read_text()
    for name in STUDIES:
        study, told = STUDIES.get(name), [f"`{name}`"]
        tasks = [] if name in WITH_TASKS else [task.id for task in PAPER_TASKS]
        for size in (scale("quick"), scale("standard")):
            cells, steps = cells_of(study, tasks, size, size.seeds), 0
            for cell in cells:
                last, one = cell.settings.final, cell.settings.candidate.steps
                search, final = cell.most_steps
                assert final == (last.finalists + 3) * last.seeds * last.steps
                if cell.retrains or cell.settings.method.name in ("given", "reference"):
                    assert search == one
                assert one <= search <= cell.budget_steps
                steps += search + final
            told += [f"{len(cells):,}", f"{steps:,}"]
        assert f"| {' | '.join(told)} |" in page
        assert f"robomore study {name} " in page


@pytest.mark.parametrize("error", [KeyboardInterrupt, Interrupted])
def test_a_study_that_is_stopped_counts_its_cells(
    error: type[BaseException], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C reaches the study itself, or the run of a cell, which speaks of that cell alone."""
    study, cells = some()
    told: list[tuple[int, str]] = []

    def tell(index: int, cell: Cell):  # type: ignore[no-untyped-def]
        if index == 2:
            raise error
        return ignore

    def ended(index: int, cell: Cell, run: Run) -> None:
        told.append((index, run.task.id))

    with pytest.raises(Interrupted, match=r"stopped; 2 of 3 runs are done and kept in .*same comm"):
        run_study(study, cells, tmp_path, executor="untrained", tell=tell, ended=ended)
    assert told == [(0, "swimmer"), (1, "swimmer")]
    assert len(run_study(study, cells, tmp_path, executor="untrained").cells) == 3
