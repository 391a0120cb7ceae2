"""The page that compares runs: all numbers of a row are of the same design."""

from __future__ import annotations

from pathlib import Path

import pytest

from fake_run import FOUND_FITNESS, FakeRun
from robomore.report.comparison import _groups, _rows, render_comparison
from robomore.runs import load_run


def test_a_method_s_row_is_of_what_its_searches_found(tmp_path: Path) -> None:
    fake = FakeRun(tmp_path)
    best = fake.coarse()
    fake.final(best, champion="reward_only")
    run = load_run(tmp_path)
    assert run.champion_role == "reward_only"
    assert run.champion and run.found and run.found.efficiency
    assert run.reference and run.reference.efficiency
    (row,) = _rows(_groups([run]))
    mean = sum(FOUND_FITNESS) / len(FOUND_FITNESS)
    assert row["fitness"].mean == pytest.approx(mean)
    assert row["volume"] == pytest.approx(run.found.volume) != run.champion.volume
    assert row["found"].mean == pytest.approx(mean / row["volume"])
    assert row["ratio"].mean == pytest.approx(
        run.found.efficiency.mean / run.reference.efficiency.mean
    )
    page = render_comparison([run])
    assert "found over reference" in page and "of the designs that the searches found" in page
