"""`audit`: where it is kept, what it tells, and what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from audit.canned import copy_with_canned_audits
from cli.commands import Command
from robomore.runs import load_run
from robomore.runs.audits import audit_of
from robomore.store.audit import AUDIT
from robomore.store.champion import check_sums


@pytest.fixture
def copied(trained_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return copy_with_canned_audits(trained_run, tmp_path, monkeypatch)


def test_an_audit_lies_beside_its_policy_and_is_told(copied: Path, robomore_: Command) -> None:
    assert audit_of(load_run(copied)) is None
    assert "audit:" not in robomore_("show", copied).out
    assert robomore_("show", copied, "--json").json["audit"] is None
    assert "It is not audited." in robomore_("show", copied / "champion").out
    said = robomore_("audit", copied)
    assert said.status == 1
    assert "fails energy balance" in said.words and "fails 1 of 2 checks" in said.words
    assert "at the reference design's density (1,000 kg/m³" in said.words
    found = load_run(copied)
    kept = copied / "artifacts" / found.kept().artifact / AUDIT
    audit = audit_of(found)
    assert kept.is_file() and audit is not None and not audit.passes
    assert robomore_("audit", copied, "--json").json["passes"] is False
    assert "5 J came \\| from nowhere." in robomore_("audit", copied, "--markdown").out
    assert audit_of(found, found.reference.evaluations[0].key) is None  # type: ignore[union-attr]
    assert "audit: The design fails 1 of 2 checks" in robomore_("show", copied).words
    assert robomore_("show", copied, "--json").json["audit"] == json.loads(kept.read_text())
    assert "fails energy balance" in robomore_("show", copied / "champion").words


def test_a_design_outside_of_a_run_is_audited(copied: Path, robomore_: Command) -> None:
    assert robomore_("audit", copied / "champion").status == 1
    assert (copied / "champion" / AUDIT).is_file()
    check_sums(copied / "champion")  # an audit is no part of the design
    assert "audit: The design fails 1 of 2 checks" in robomore_("show", copied).words
    (copied / "run.json").write_text("{")
    assert "fails energy balance" in robomore_("show", copied / "champion").words
    (copied / "champion" / AUDIT).unlink()
    assert "It is not audited." in robomore_("show", copied / "champion").words


def test_what_cannot_be_audited_is_refused(tmp_path: Path, robomore_: Command) -> None:
    said = robomore_("audit", tmp_path)
    assert said.status == 2 and "neither a run folder nor a design" in said.err
    said = robomore_("audit", tmp_path, "--json", "--markdown")
    assert said.status == 2 and "not both" in said.err
