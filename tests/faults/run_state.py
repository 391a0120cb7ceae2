"""What a run has left in its folder, in a form that two runs can be compared by."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

from robomore.store import Ledger, RunFolder
from robomore.types import Status

Number = tuple[str, str, Status, float | None, tuple[float, ...]]


def numbers(out: Path) -> list[Number]:
    """Return what was measured in each place."""
    with closing(Ledger(RunFolder(out).ledger, read_only=True)) as ledger:
        placed = ledger.placed()
        assert len({e.key for _, e in placed}) == len(ledger.evaluations())
    return sorted(
        (repr(place), e.key, e.status, e.efficiency, e.episode_fitness) for place, e in placed
    )


def champion(out: Path) -> dict[str, bytes]:
    """Return the answer, file by file."""
    return {path.name: path.read_bytes() for path in RunFolder(out).champion.iterdir()}


def files(out: Path) -> set[str]:
    """Return the names of all files but those that SQLite keeps beside the ledger."""
    found = (path.relative_to(out).as_posix() for path in out.rglob("*") if path.is_file())
    return {name for name in found if not name.startswith("ledger.sqlite-")}


def rows(out: Path) -> dict[str, tuple[Any, ...]]:
    """Return every evaluation's row by key, with its time: one that is done again has another."""
    path = RunFolder(out).ledger
    if not path.is_file() or not path.stat().st_size:
        return {}
    with closing(sqlite3.connect(path)) as db:
        try:
            return {row[0]: row for row in db.execute("SELECT * FROM evaluations")}
        except sqlite3.OperationalError:  # no tables yet
            return {}


def same_run(out: Path, undisturbed: Path) -> None:
    """Make sure that two runs have one champion, the same numbers and the same files."""
    assert numbers(out) == numbers(undisturbed)
    assert champion(out) == champion(undisturbed)
    assert files(out) == files(undisturbed)
