"""An audit for which nothing runs."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from robomore.audit import Audit, Subject, Verdict

VERDICTS = (
    Verdict("other seeds", "passes", "12 m.", {"fitness_m": 12.0}),
    Verdict("energy balance", "fails", "5 J came | from nowhere.", {"created_j": 5.0}),
)


def canned(subject: Subject) -> Audit:
    """Return an audit for which nothing runs."""
    facts = {"density": 1000.0, "mass": 1.0, "fitness": 1.0, "efficiency": 2.0}
    return Audit(subject.task.id, subject.policy.digest, 1, 12.0, 0.5, 24.0, facts, VERDICTS)


def copy_with_canned_audits(run: Path, out: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a copy of a run whose audits take no time from now on."""
    monkeypatch.setattr("robomore.experiment.auditing.audit", canned)
    return Path(shutil.copytree(run, out / "run"))
