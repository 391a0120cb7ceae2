"""Opening a ledger's file: to go on writing, or to look at it wherever it lies."""

from __future__ import annotations

import sqlite3
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory

from robomore.errors import RunFolderError
from robomore.plain_files import PlainFolder, read_plain, write_plain

_PATIENCE_SECONDS = 60.0
"""How long one connection of a run waits for another one's commit."""

DAMAGE = frozenset(
    (
        sqlite3.SQLITE_ERROR,  # a table that is gone, a statement in the file that is none
        sqlite3.SQLITE_CORRUPT,
        sqlite3.SQLITE_NOTADB,
        sqlite3.SQLITE_MISMATCH,
        sqlite3.SQLITE_CONSTRAINT,
        sqlite3.SQLITE_TOOBIG,
        sqlite3.SQLITE_NOMEM,  # asked for by a length that is none
        sqlite3.SQLITE_IOERR_READ,
        sqlite3.SQLITE_IOERR_SHORT_READ,
    )
)
"""SQLite's codes for a file that is not what was written. Others blame the disk or the medium."""

BROKEN = (sqlite3.Error, OverflowError, UnicodeDecodeError)
"""What reading a damaged file may raise; the others where a name or a number makes no sense."""

BESIDE = ("-wal", "-shm")
"""What SQLite keeps beside a file that is open, or whose process was killed."""


_MOST_IN_A_ROW = 2**26
"""Bytes of a row; longer ones count as damage. The longest are exchanges with pictures."""

_MOST_BYTES = 2**34
"""Size of a ledger that is copied."""


class DamageError(Exception):
    """The file is none that a run has begun."""


def open_to_write(path: Path, durable: bool, stack: ExitStack) -> sqlite3.Connection:
    """Return a connection to the file at `path`, which is made if it is missing. `stack` closes it.

    If `durable`, a commit survives the machine, not only the process.

    Raises:
        RunFolderError: see `refuse_unsafe`.
    """
    refuse_unsafe(path, to_write=True)
    new = not path.exists() or not path.stat().st_size
    db = _connected(str(path), stack)
    if new:
        # So that there is never a rollback journal beside it, not even at the very first.
        db.execute("PRAGMA journal_mode=MEMORY")
    # Readers never wait for the writer, and a commit survives the process being killed.
    db.execute("PRAGMA journal_mode=WAL")
    db.execute(f"PRAGMA synchronous={'FULL' if durable else 'NORMAL'}")
    return db


def open_to_read(path: Path, stack: ExitStack) -> sqlite3.Connection:
    """Return a connection that changes nothing, on a medium that cannot be written too.

    SQLite reads a file in WAL mode only where it may make files beside it, or where they are there
    already. Where neither is so, a copy is read: to look at the file without its log, as SQLite's
    `immutable` does, would leave out what a killed run wrote last. `stack` closes the connection
    and removes the copy.

    Raises:
        DamageError: nothing has been written yet.
        RunFolderError: see `refuse_unsafe`.
    """
    refuse_unsafe(path)
    try:
        return _begun(_connected(f"{path.absolute().as_uri()}?mode=ro", stack, uri=True))
    except sqlite3.OperationalError as error:
        not_writable = (sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_READONLY)
        if error.sqlite_errorcode & 0xFF not in not_writable or not path.is_file():
            raise
    folder = Path(stack.enter_context(TemporaryDirectory(prefix="robomore-")))
    copy = copy_ledger(path, folder / path.name)
    return _begun(_connected(str(copy), stack))


def copy_ledger(path: Path, copy: Path) -> Path:
    """Copy the file with what its log holds; returns `copy`."""
    write_plain(copy, read_plain(path, _MOST_BYTES))
    log = path.with_name(path.name + "-wal")
    if log.exists():
        write_plain(copy.with_name(copy.name + "-wal"), read_plain(log, _MOST_BYTES))
    return copy


def refuse_unsafe(path: Path, to_write: bool = False) -> None:
    """Refuse a database if it, or what stands beside it, could make SQLite touch other files.

    A rollback journal is not needed here, and SQLite may remove a file that one names.

    Raises:
        RunFolderError: one of the files is no plain file; there is a rollback journal; or, if
            `to_write`, the database is also the file of another name.
    """
    folder = PlainFolder(path.parent)
    for ending in ("", *BESIDE):
        folder.is_file(path.name + ending)
    if folder.kind(f"{path.name}-journal"):
        raise RunFolderError(
            f"{path}-journal is a rollback journal, which no run leaves behind and which SQLite "
            "would follow to other files; remove it, or do not use this run folder"
        )
    if to_write and path.exists() and path.stat().st_nlink > 1:
        raise RunFolderError(
            f"{path} is the same file as another one (a hard link), which would be changed too; "
            "make a copy of the run folder and go on there"
        )


def _connected(name: str, stack: ExitStack, uri: bool = False) -> sqlite3.Connection:
    db = sqlite3.connect(name, timeout=_PATIENCE_SECONDS, uri=uri, check_same_thread=False)
    stack.callback(db.close)
    db.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, _MOST_IN_A_ROW)
    return db


def _begun(db: sqlite3.Connection) -> sqlite3.Connection:
    if db.execute("PRAGMA user_version").fetchone() == (0,):
        raise DamageError("nothing has been written into it yet")
    return db
