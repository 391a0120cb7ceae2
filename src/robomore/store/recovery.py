"""What is whole in a damaged ledger, put into a new one.

Every row carries a digest of itself, so a row that can be read and agrees with it is right,
whatever happened around it. What is lost is found to be missing when the run goes on, and done
again.
"""

from __future__ import annotations

import logging
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing, suppress
from pathlib import Path
from typing import Any

from robomore.errors import LedgerDamaged
from robomore.plain_files import PlainFolder
from robomore.store.ledger import Ledger
from robomore.store.opening import BESIDE, BROKEN, copy_ledger, open_to_write
from robomore.store.rows import digest
from robomore.store.schema import SCHEMA, TABLES, check_row, is_readable

log = logging.getLogger(__name__)


def open_or_recover(path: Path) -> Ledger:
    """Return the ledger at `path`, opened to go on writing; a new one with the whole rows of a
    damaged one, which is kept beside it.

    Raises:
        LedgerError: of another version, or nothing in it can be read.
        StorageFailed: the disk is full, or cannot be written.
    """
    try:
        if path.exists() and not path.stat().st_size:
            log.warning("%s is empty; whatever it held is done again", path)
        return Ledger(path)
    except LedgerDamaged:
        copy = _unused(path)
        copy_ledger(path, copy)
        kept = _salvage(copy, path)
        if not kept:
            _remove(copy, "", *BESIDE)
            raise LedgerDamaged(
                f"the ledger {path} is damaged and nothing in it can be read; restore it from a "
                "copy, or start anew with another --out"
            ) from None
    log.warning(
        f"the ledger was damaged: {kept} rows are whole and kept, the rest is done again; "
        f"the damaged file is kept as {copy}"
    )
    return Ledger(path)


def _salvage(damaged: Path, path: Path) -> int:
    """Put the whole rows of `damaged`, if any, in the place of `path`; return how many."""
    partial = path.with_suffix(".partial")
    _remove(partial, "", *BESIDE)
    kept = 0
    with ExitStack() as stack:
        try:
            old = open_to_write(damaged, durable=False, stack=stack)
            if old.execute("PRAGMA user_version").fetchone() != (SCHEMA,):
                return 0
        except BROKEN:
            return 0
        new = stack.enter_context(closing(Ledger(partial)))
        for table in TABLES:
            for row in _rows(old, table):
                new.restore(table, row)
                kept += 1
    if kept:
        # SQLite would take an old log for the new file's.
        _remove(path, *BESIDE)
        PlainFolder(path.parent).replace(partial.name, path.name)
    else:
        _remove(partial, "")
    return kept


def _remove(path: Path, *endings: str) -> None:
    for ending in endings:
        PlainFolder(path.parent).remove(path.name + ending)


def _rows(db: sqlite3.Connection, table: str) -> Iterator[tuple[Any, ...]]:
    """Yield the whole rows of a table in order, from both ends towards what cannot be read."""
    found: dict[int, tuple[Any, ...]] = {}
    try:
        if not is_readable(db, table):
            return
    except BROKEN:
        return
    for order in ("ASC", "DESC"):
        # A damaged schema or page ends the reading, not what was read before.
        with suppress(*BROKEN):
            for number, *row in db.execute(f"SELECT rowid, * FROM {table} ORDER BY rowid {order}"):
                if number in found:
                    break
                if _is_whole(table, row):
                    found[number] = tuple(row)
    for number in sorted(found):
        yield found[number]


def _is_whole(table: str, row: Sequence[Any]) -> bool:
    try:
        check_row(table, tuple(row))
    except ValueError:
        return False
    return bool(digest(row[:-1]) == row[-1])


def _unused(path: Path) -> Path:
    number = 1
    folder = PlainFolder(path.parent)
    while folder.kind(copy := f"{path.stem}-damaged-{number}{path.suffix}"):
        number += 1
    return path.with_name(copy)
