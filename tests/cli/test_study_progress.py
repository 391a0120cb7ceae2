"""What a study tells as it runs: results, and about how long all of its cells still take."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import untrained  # noqa: F401  # makes its executor known
from cli.commands import Command
from robomore.cli.study_progress import StudyProgress
from robomore.events import BatchBegan, Finished, RunBegan, Started
from robomore.experiment import run
from robomore.plan import Plan, Stage
from robomore.runs import Run
from robomore.studies import STUDIES, Cell
from robomore.studies.execute import cells_of
from robomore.studies.presets import scale
from robomore.types import Place


@pytest.fixture(scope="module")
def cell_run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """A small run of the study below."""
    cell = cells()[0]
    out = tmp_path_factory.mktemp("cell") / "run"
    return run(cell.task, cell.settings, executor="untrained", out=out)


def cells() -> list[Cell]:
    return cells_of(STUDIES.get("transfer"), ["swimmer"], scale("smoke"), 4)


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


def began(cell: Cell, folder: Path) -> RunBegan:
    plan = Plan((Stage(name="coarse", evaluations=1, steps=cell.settings.candidate.steps),))
    return RunBegan(cell.task, "", cell.settings, plan, "", "", 0, 1, folder)


def test_each_result_is_told_with_the_time_that_all_cells_take(
    cell_run: Run, tmp_path: Path
) -> None:
    said: list[str] = []
    clock, all_cells = Clock(), cells()
    progress = StudyProgress(all_cells, 1, said.append, clock)
    for index, cell in enumerate(all_cells):
        observe = progress.begin(index, cell)
        if index:  # the first one was finished before
            observe(began(cell, tmp_path))
        clock.now += 600.0 if index else 1.0
        progress.end(index, cell, cell_run)
    assert said[0] == "run 1 of 4: swimmer-robomore-s0\n"
    assert said[1].startswith("swimmer-robomore-s0: ") and said[1].endswith("(kept from before)\n")
    assert " m/m³, the reference design " in said[1]
    assert said[3].endswith("(10 min 00 s); about 20 min left for all runs\n")
    assert said[5].endswith("(10 min 00 s); about 10 min left for all runs\n")
    assert said[7].endswith("(10 min 00 s)\n")


def test_cells_side_by_side_share_the_time(cell_run: Run, tmp_path: Path) -> None:
    said: list[str] = []
    clock, all_cells = Clock(), cells()
    progress = StudyProgress(all_cells, 2, said.append, clock)
    for index in (0, 1):
        progress.begin(index, all_cells[index])(began(all_cells[index], tmp_path))
    clock.now = 1200.0
    progress.end(0, all_cells[0], cell_run)
    # The other one takes as long as the first, so it is at its end; two wait for two places.
    assert said[-1].endswith("(20 min 00 s); about 20 min left for all runs\n")


def test_a_long_cell_is_told_of_before_its_end(cell_run: Run, tmp_path: Path) -> None:
    said: list[str] = []
    clock, (cell, *_) = Clock(), cells()
    progress = StudyProgress([cell], 1, said.append, clock)
    observe = progress.begin(0, cell)
    observe(began(cell, tmp_path))
    evaluation, place = cell_run.evaluations[0], Place(stage="coarse")
    evaluation = replace(evaluation, key="a")
    observe(BatchBegan((place,), 0))
    observe(Started("a", place, evaluation.job.steps))
    clock.now = 30.0
    observe(Finished(evaluation, place, known=False))
    assert len(said) == 1  # not before a minute has passed
    clock.now = 100.0
    observe(Finished(evaluation, place, known=False))
    assert said[1].startswith("swimmer-robomore-s0: coarse 1/1; about ")


def test_what_is_measured_again_is_said() -> None:
    said: list[str] = []
    (cell, *_) = all_cells = cells()
    progress = StudyProgress(all_cells, 1, said.append, Clock())
    for count in (1, 4):
        progress.measure(0, cell, count)
    assert said[0] == f"{cell.folder.name}: 1 policy is measured again, for the curves\n"
    assert said[1] == f"{cell.folder.name}: 4 policies are measured again, for the curves\n"


def test_what_was_not_found_is_said(cell_run: Run) -> None:
    said: list[str] = []
    (cell, *_) = all_cells = cells()
    progress = StudyProgress(all_cells, 1, said.append, Clock())
    progress.begin(0, cell)
    progress.end(0, cell, replace(cell_run, found=None))
    assert "found nothing that could be trained" in said[-1]


def test_an_arm_that_changes_nothing_is_refused(robomore_: Command) -> None:
    said = robomore_("study", "ablation", "--arm", "without-screening", "--plan")
    assert said.status == 2
    assert "--arm without-screening changes nothing at the preset quick" in said.err
