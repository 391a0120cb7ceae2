"""Audits of runs: whom they are about, and the seat of the champion."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import untrained  # noqa: F401  # makes its executor known
from audit.canned import VERDICTS, copy_with_canned_audits
from robomore.audit import Audit, Subject
from robomore.errors import FitnessFailed, InputError
from robomore.experiment import auditing, run
from robomore.options import with_options
from robomore.plain_files import PlainFolder
from robomore.report import as_data
from robomore.report.audit_words import as_markdown
from robomore.runs import load_run
from robomore.runs.audits import audit_of
from robomore.settings import preset
from robomore.store import RunFolder
from robomore.store.audit import AUDIT, load_audit, save_audit
from robomore.tasks import get_task
from robomore.training.policy import MLPPolicy


@pytest.fixture
def copied(trained_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return copy_with_canned_audits(trained_run, tmp_path, monkeypatch)


def test_an_audit_of_another_policy_says_nothing(copied: Path) -> None:
    auditing.audit_run(copied)
    found = load_run(copied)
    name = f"artifacts/{found.kept().artifact}/{AUDIT}"
    files = PlainFolder(copied)
    audit = load_audit(files, name)
    assert audit is not None
    save_audit(files, name, replace(audit, policy="0" * 64))
    assert audit_of(found) is None


@pytest.mark.parametrize(
    "content", [b"", b"[1]", b'{"task": 1}', b'{"format": 99}', b"[" * 100_000], ids=range(5)
)
def test_a_file_that_is_no_audit(content: bytes, tmp_path: Path) -> None:
    (tmp_path / AUDIT).write_bytes(content)
    with pytest.raises(ValueError, match=AUDIT):
        load_audit(PlainFolder(tmp_path), AUDIT)


def test_a_policy_of_another_robot_is_refused(tmp_path: Path) -> None:
    task = get_task("swimmer")
    layer = np.zeros((27, 8), np.float32)
    ants = MLPPolicy((layer,), (np.zeros(8, np.float32),))
    with pytest.raises(InputError, match="gives 8, where this robot has 8 observations"):
        auditing.audit_design(tmp_path, task, task.reference, ants)


def test_a_group_of_the_final_is_doubted_by_an_audit_of_its_own_policy(
    copied: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = load_run(copied)
    assert found.champion is not None
    group = found.champion.evaluations
    evaluator: Any = SimpleNamespace(folder=RunFolder(copied), restore_policies=lambda some: None)
    said = "energy balance: 5 J came | from nowhere."
    assert auditing.doubt(evaluator, found.task, "efficiency", group) == said
    best = max(group, key=lambda e: e.efficiency or 0.0)
    files, name = PlainFolder(copied), f"artifacts/{best.artifact}/{AUDIT}"
    known = load_audit(files, name)
    assert known is not None
    sound = replace(known, verdicts=VERDICTS[:1])
    save_audit(files, name, sound)
    assert not auditing.doubt(evaluator, found.task, "efficiency", group), "what is known is read"
    save_audit(files, name, replace(sound, policy="0" * 64))
    assert auditing.doubt(evaluator, found.task, "efficiency", group) == said
    files.write(name, b"[")
    assert auditing.doubt(evaluator, found.task, "efficiency", group) == said

    def fails(subject: Subject) -> Audit:
        raise FitnessFailed("the fitness gave nan")

    monkeypatch.setattr("robomore.experiment.auditing.audit", fails)
    files.write(name, b"[")
    told = auditing.doubt(evaluator, found.task, "efficiency", group)
    assert told.endswith("other episodes: the fitness gave nan")


def test_a_fitness_that_a_folder_holds_is_not_executed(
    copied: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = load_run(copied)
    monkeypatch.setattr(auditing, "is_foreign", lambda goal: True)
    parameters = found.task.reference
    with pytest.raises(InputError, match="so nothing can be measured anew"):
        auditing.audit_design(copied / "champion", found.task, parameters, found.load_policy())


def test_what_was_passed_over_is_told(tmp_path: Path) -> None:
    """No policy here fits its robot, so nothing can be audited, and the reference is champion."""
    settings = with_options(preset("smoke"), require_audit=True)
    found = run("swimmer", settings, seed=1, executor="untrained", out=tmp_path / "run")
    assert found.champion_role == "reference" or not found.passed_over
    assert all(
        "its fitness cannot be measured in other episodes" in one for one in found.passed_over
    )
    told = [one for one in found.warnings if one.startswith("Not champion")]
    assert len(told) == len(found.passed_over) > 0
    assert as_data(found)["passed_over"] == list(found.passed_over)


def test_a_table_is_no_place_for_markup() -> None:
    audit = Audit("t", "", 1, None, 1.0, None, {"density": 1.0, "mass": 1.0}, VERDICTS)
    assert "came \\| from" in as_markdown(audit, "m") and "the physics diverges" in as_markdown(
        audit, "m"
    )
