"""What else happens to a run: a clock that jumps, a second run, another version, no luck at all."""

from __future__ import annotations

import ast
import random
import shutil
import sqlite3
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from lives import PATIENCE, life
from quick_run import SMOKE
from refusals import Command, refused
from run_state import champion, numbers, rows, same_run

import robomore
from robomore.executors import worker_process
from robomore.store import RunFolder

CLOCKS = {
    "time.time",
    "time.time_ns",
    "time.localtime",
    "time.gmtime",
    "datetime.now",
    "date.today",
}


def test_a_jumping_clock_changes_nothing(
    undisturbed: Path, tmp_path: Path, robomore_: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    jumps = random.Random(5)
    monkeypatch.setattr(time, "time", lambda: jumps.uniform(-1e9, 5e9))
    monkeypatch.setattr(time, "time_ns", lambda: int(jumps.uniform(-1e18, 5e18)))
    out = tmp_path / "run"
    assert robomore_(*SMOKE, "--out", out).status == 0
    same_run(out, undisturbed)
    assert robomore_(*SMOKE, "--out", out).status == 0
    assert robomore_("show", out).status == 0
    same_run(out, undisturbed)


def test_the_wall_clock_is_read_where_rows_are_dated_and_nowhere_else() -> None:
    source = Path(robomore.__file__).parent
    readers = {
        path.relative_to(source).as_posix()
        for path in source.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Attribute) and ast.unparse(node) in CLOCKS
    }
    # A live page says when what it shows was read.
    shown = {"monitor/progress.py", "serve/live.py", "serve/folder.py"}
    assert readers - shown == {"store/rows.py"}


def test_a_second_run_in_the_folder_is_refused_and_the_first_is_not_disturbed(
    undisturbed: Path, tmp_path: Path, robomore_: Command
) -> None:
    out = tmp_path / "run"
    with life(out, "slow") as first:
        while not RunFolder(out).ledger.exists() and first.lasts_until(PATIENCE, step=0.02):
            continue
        second = robomore_(*SMOKE, "--out", out)
        assert first.parent.poll() is None, "too late to tell"
        refused(second, "a run that goes on")
        assert "in use by another run" in second.err
        status, said = first.end()
    assert status == 0, said
    same_run(out, undisturbed)


@pytest.mark.parametrize(("version", "words"), [(99, "install a newer"), (1, "that wrote it")])
def test_a_ledger_of_another_version_is_left_alone(
    version: int, words: str, undisturbed: Path, tmp_path: Path, robomore_: Command
) -> None:
    out = tmp_path / "run"
    shutil.copytree(undisturbed, out)
    with closing(sqlite3.connect(RunFolder(out).ledger)) as db:
        db.execute(f"PRAGMA user_version = {version}")
        db.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    before = RunFolder(out).ledger.read_bytes()
    for arguments in (("show", out), ("report", out), (*SMOKE, "--out", out)):
        said = robomore_(*arguments)
        assert said.status == 2 and said.err.count("\n") == 1 and said.out == ""
        assert words in said.err
    assert RunFolder(out).ledger.read_bytes() == before
    assert not list(out.glob("ledger-damaged*"))


@pytest.mark.parametrize("environment_of_nobody", [lambda: {"PATH": "\0"}, lambda: 1 / 0])
def test_where_no_worker_can_be_started_no_design_is_blamed(
    environment_of_nobody: Callable[[], Any],
    undisturbed: Path,
    tmp_path: Path,
    robomore_: Command,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    out = tmp_path / "run"
    with monkeypatch.context() as patch:
        patch.setattr(worker_process, "clean_environment", environment_of_nobody)
        said = robomore_(*SMOKE, "--out", out)
    refused(said, "no worker", status=1)
    assert not rows(out)
    assert robomore_(*SMOKE, "--out", out).status == 0
    assert numbers(out) == numbers(undisturbed)
    assert champion(out) == champion(undisturbed)
