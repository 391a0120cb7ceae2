"""What a notebook shows of a run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from fake_run import NASTY, FakeRun, economy_run, finished_run
from robomore.report import notebook
from robomore.runs import load_run
from robomore.runs.words import number


def test_a_run_shows_itself_in_numbers_and_moving(trained_run: Path) -> None:
    run = load_run(trained_run)
    shown = run._repr_html_()
    assert "<table>" in shown and "efficiency" in shown
    assert shown.count('src="data:image/webp;base64,') == 1
    # Made once: the same bytes again, without a second rendering.
    assert run._repr_html_() == shown and len(notebook._MADE) >= 1


def test_designs_without_a_policy_stand_still_and_text_stays_text(tmp_path: Path) -> None:
    finished_run(tmp_path / "one")
    run = load_run(tmp_path / "one")
    shown = replace(run, manifest=replace(run.manifest, seed=3))._repr_html_()
    assert shown.count("<svg") == 2 and "seed 3" in shown and "base64" not in shown
    assert "<script" not in shown and NASTY not in shown


def test_what_the_task_of_today_refuses_has_its_numbers_still(tmp_path: Path) -> None:
    economy_run(tmp_path / "one")
    run = load_run(tmp_path / "one")
    assert run.champion is not None
    # Since the run, the task has come to refuse all that is thinner than the reference.
    parameters = tuple(replace(one, low=one.reference) for one in run.task.parameters)
    edited = replace(run, task=replace(run.task, parameters=parameters))
    shown = edited._repr_html_()
    assert shown.count("<svg") == 1 and "efficiency" in shown
    score = run.champion.score(run.objective)
    assert score is not None
    assert f"<td>transport economy</td><td>{number(score.mean)}" in shown


def test_a_run_without_anything_is_shown_too(tmp_path: Path) -> None:
    FakeRun(tmp_path / "one").folder.ledger.touch()
    from robomore.store import Ledger

    Ledger(tmp_path / "one" / "ledger.sqlite").close()
    assert "not finished" in load_run(tmp_path / "one")._repr_html_()
