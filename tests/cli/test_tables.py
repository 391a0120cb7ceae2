"""`compare` and `export`: runs as tables."""

from __future__ import annotations

import csv
import io
from dataclasses import replace
from pathlib import Path

import pytest
from rich.console import Console

from cli.commands import Command
from fake_run import SETTINGS, FakeRun, random_run
from robomore.runs import load_run
from robomore.settings import Budget, FinalSettings


@pytest.fixture(scope="module")
def others(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A run of another method, and one that goes on."""
    folder = tmp_path_factory.mktemp("others")
    random_run(folder / "random")
    FakeRun(folder / "open").coarse()
    return folder / "random", folder / "open"


def test_compare_prints_a_row_for_each_run(
    robomore_: Command, finished: Path, others: tuple[Path, Path]
) -> None:
    said = robomore_("compare", finished, *others)
    assert said.status == 0, said.err
    head, first, second, third, *_ = said.out.splitlines()
    assert "found over the reference" in head
    assert first.split()[:4] == ["finished", "swimmer", "robomore", "7"]
    assert "95 % interval" in first and "5 seeds" in first
    assert second.split()[2] == "random"
    assert "not finished" in third


def test_compare_tells_quick_from_standard_and_fits_a_terminal(
    robomore_: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    longer = replace(
        SETTINGS,
        objective="fitness",
        candidate=Budget(steps=150_000, episodes=10),
        final=FinalSettings(steps=300_000, episodes=20, seeds=3),
    )
    for name, settings in (("quick", SETTINGS), ("standard", longer)):
        run = FakeRun(tmp_path / name, settings=settings)
        run.final(run.coarse())
    folders = tmp_path / "quick", tmp_path / "standard"
    rows = robomore_("compare", *folders, "--json").json
    asked = ("objective", "training_steps", "final_training_steps", "final_seeds_asked")
    assert [tuple(row[name] for name in asked) for row in rows] == [
        ("efficiency", 1_000, 4_000, 5),
        ("fitness", 150_000, 300_000, 3),
    ]
    assert robomore_("compare", *folders).out.splitlines()[3:] == [
        "quick: efficiency, trainings of 1,000 steps; final of 5 seeds, 4,000 steps",
        "standard: fitness, trainings of 150,000 steps; final of 3 seeds, 300,000 steps",
        "These runs were not asked for the same: compare only those of one line.",
    ]
    alike = robomore_("compare", folders[0], folders[0]).out.splitlines()
    assert alike[3:] == [
        "each run: efficiency, trainings of 1,000 steps; final of 5 seeds, 4,000 steps"
    ]

    said = io.StringIO()
    narrow = Console(width=100, file=said, force_terminal=True, color_system=None)
    monkeypatch.setattr("robomore.cli.tables.console", lambda: narrow)
    robomore_("compare", *folders)
    told = said.getvalue()
    assert max(map(len, told.splitlines())) <= 100
    for word in ("efficiency", "fitness", "300,000", "standard", "swimmer", "robomore", "95 %"):
        assert word in told


def test_compare_gives_the_same_rows_as_json_and_as_csv(
    robomore_: Command, finished: Path, others: tuple[Path, Path], tmp_path: Path
) -> None:
    rows = robomore_("compare", finished, *others, "--json").json
    assert [row["method"] for row in rows] == ["robomore", "random", "robomore"]
    assert rows[0]["ratio_low"] < rows[0]["ratio"] < rows[0]["ratio_high"]
    assert robomore_("compare", finished, *others, "--csv", tmp_path / "a.csv").status == 0
    text = robomore_("compare", finished, *others, "--csv", "-").out
    assert (tmp_path / "a.csv").read_text() == text.replace("\r\n", "\n")
    read = list(csv.DictReader(io.StringIO(text)))
    assert [float(row["champion"]) for row in read] == [row["champion"] for row in rows]


def test_export_writes_every_evaluation(robomore_: Command, finished: Path, tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    said = robomore_("export", finished, "--csv", file)
    assert said.status == 0 and str(file) in said.out
    with file.open(newline="") as text:
        read = list(csv.DictReader(text))
    assert len(read) == len(load_run(finished).records)
    shown = robomore_("export", finished, "--csv", "-").out
    assert list(csv.DictReader(io.StringIO(shown))) == read


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("compare",), "which runs?"),
        (("compare", "RUN", "nowhere"), "there is no folder nowhere; name a folder that"),
        (("compare", "RUN", "--csv", "nowhere/a.csv"), "cannot write nowhere/a.csv"),
        (("export", "RUN"), "--csv FILE"),
        (("export", "RUN", "--csv", "a.csv", "--reference"), "--to FOLDER"),
        (("export", "RUN", "--csv", "nowhere/a.csv"), "cannot write nowhere/a.csv"),
        (("export", "nowhere", "--csv", "a.csv"), "there is no folder nowhere; name a folder that"),
    ],
)
def test_mistakes_are_one_line(
    robomore_: Command,
    finished: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    words: tuple[str, ...],
    expected: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    said = robomore_(*(str(finished) if word == "RUN" else word for word in words))
    assert (said.status, said.out) == (2, "")
    assert expected in said.err and said.err.count("\n") == 1
