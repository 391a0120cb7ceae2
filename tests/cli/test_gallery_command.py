"""`gallery` makes one, and `show` reads it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from audit.canned import copy_with_canned_audits
from cli.commands import Command
from robomore.cli.gallery import _over_reference
from robomore.runs.gallery import load_gallery
from robomore.runs.words import number

GALLERY = Path(__file__).parents[2] / "docs" / "results" / "standard"


@pytest.fixture
def copied(trained_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return copy_with_canned_audits(trained_run, tmp_path, monkeypatch)


def test_a_gallery_is_made_and_shown(copied: Path, tmp_path: Path, robomore_: Command) -> None:
    gallery = tmp_path / "gallery"
    said = robomore_("gallery", copied, "--out", gallery)
    assert said.status == 0 and "auditing" in said.err
    assert "fails: energy balance" in robomore_("show", gallery).words
    (told,) = robomore_("show", gallery, "--json").json
    assert told["name"] == "run" and told["audit"]["passes"] is False
    one = robomore_("show", gallery / "run")
    assert one.status == 0
    assert "front_radius m" in one.out and "_get_rew" in one.out and "energy balance" in one.out
    assert robomore_("show", gallery / "run", "--json").json == told


def test_what_equal_density_leaves_is_of_the_audit(robomore_: Command) -> None:
    # The Ant's champion has the human design's density; its best seed does more than its mean.
    shown = robomore_("show", GALLERY).out.splitlines()
    (heading, ant, cheetah) = (
        next(line for line in shown if line.startswith(name))
        for name in ("champion", "ant-standard", "half-cheetah-standard")
    )
    assert "kept at equal density" in heading
    assert " 100 %" in ant and " 0.708 %" in cheetah


def test_a_gallery_divides_what_the_run_compared() -> None:
    entry = load_gallery(GALLERY)[0]
    assert entry.origin is not None and entry.efficiency is not None
    mean = sum(entry.origin.reference_efficiency) / len(entry.origin.reference_efficiency)
    assert _over_reference(entry) == number(entry.efficiency / mean, 3)
    scores = {entry.origin.role: (0.6, 0.8), "reference": (0.2,)}
    origin = replace(entry.origin, objective="transport-economy", final_score=scores)
    assert _over_reference(replace(entry, origin=origin)) == "3.50 (transport economy)"


def test_what_cannot_be_used_is_refused(copied: Path, tmp_path: Path, robomore_: Command) -> None:
    assert "no run was named" in robomore_("gallery", "--out", tmp_path / "g").err
    said = robomore_("show", copied / "champion", "--reference")
    assert said.status == 2 and "is no run" in said.err
    assert "there is no folder" in robomore_("show", tmp_path / "empty").err
