"""A search method of another package: one file and an entry point, and everything works with it."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).parents[1] / "examples" / "hill-climb"


@pytest.fixture
def installed(tmp_path: Path) -> dict[str, str]:
    """The environment of a user who has installed the example."""
    site = tmp_path / "site"
    site.mkdir()
    shutil.copy(EXAMPLE / "hill_climb.py", site)
    about = site / "robomore_hill_climb-0.1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text(
        "Metadata-Version: 2.1\nName: robomore-hill-climb\nVersion: 0.1\n"
    )
    (about / "entry_points.txt").write_text(
        "[robomore.methods]\nhill-climb = hill_climb:HillClimb\nbroken = no_such_module:x\n"
    )
    paths = [str(site), str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))}


def robomore(
    environment: dict[str, str], *arguments: str | Path
) -> subprocess.CompletedProcess[str]:
    code = "import sys, untrained; from robomore.cli import main; sys.exit(main(sys.argv[1:]))"
    return subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )


def test_it_runs_with_progress_report_show_compare_and_resume(
    installed: dict[str, str], tmp_path: Path
) -> None:
    listed = robomore(installed, "methods")
    assert listed.returncode == 0
    assert "change one parameter at a time" in listed.stdout and "neighbours" in listed.stdout
    assert listed.stderr.count("broken = no_such_module:x") == 1, "a broken plug-in is one warning"

    out = tmp_path / "run"
    asked = ("run", "swimmer", "--preset", "smoke", "--method", "hill-climb")
    asked = (*asked, "--method-option", "neighbours=3", "--executor", "untrained")
    command = (*asked, "--out", out)
    done = robomore(installed, *command)
    assert done.returncode == 0, done.stderr
    assert "climb: " in done.stderr, "its stages are told as it goes on"
    again = robomore(installed, *command, "--json")
    first = json.loads(again.stdout)
    assert first["final"] and first["champion"]["efficiency"]["mean"] > 0

    shown = robomore(installed, "show", out)
    assert shown.returncode == 0 and "hill-climb" in shown.stdout
    assert robomore(installed, "report", out).returncode == 0
    page = (out / "report.html").read_text()
    assert "climb: round" in page

    other = tmp_path / "other"
    robomore(installed, *asked, "--seed", "1", "--out", other)
    compared = json.loads(robomore(installed, "compare", out, other, "--json").stdout)
    assert [row["method"] for row in compared] == ["hill-climb"] * 2
    assert [row["search_steps"] for row in compared] == [4 * 2048] * 2

    refused = robomore(installed, *command, "--method-option", "neighbours=0")
    assert refused.returncode == 2 and "neighbours" in refused.stderr
