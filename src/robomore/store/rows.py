"""Rows in one SQLite file, each with a digest of itself: damage is found and never believed.

SQLite notices damage to its own structure; a bit that flips inside a number it hands on. So the
last column of every table is a digest of all the others, and a row is read only where they agree.
"""

from __future__ import annotations

import hashlib
import threading
import time
from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from robomore.errors import LedgerDamaged, LedgerError, RoboMoReError, StorageFailed
from robomore.store.opening import BROKEN, DAMAGE, DamageError, open_to_read, open_to_write
from robomore.store.schema import CREATE, SCHEMA, foreign_objects, has_our_tables
from robomore.text import one_line

T = TypeVar("T")

MOST_BYTES = 2**28
"""Bytes that one query may read. The largest run known has 3 million in all its tables."""
MOST_NUMBERS = 10**7
"""Values that may be read from one ledger; each takes 32 bytes of memory and 2 of the file."""


class Rows:
    """A connection to a ledger's file. May be used from several threads."""

    def __init__(self, path: Path, read_only: bool, durable: bool) -> None:
        """Open the file at `path`, which is made with its tables if it is missing.

        If `read_only`, nothing is written, not
        even a new file. If `durable`, a commit survives the machine, not only the process.

        Raises:
            LedgerError: damaged, of another version, or with more in it than our own tables.
            StorageFailed: it cannot be opened now.
        """
        self._path = path
        self._lock = threading.RLock()
        self._open = ExitStack()
        self._read = 0
        try:
            if read_only:
                self._db = open_to_read(path, self._open)
            else:
                self._db = open_to_write(path, durable, self._open)
            # Before anything that would run what somebody else put into the file.
            if foreign := foreign_objects(self._db):
                raise self._foreign(foreign[0])
            (version,) = self._db.execute("PRAGMA user_version").fetchone()
            self._refuse_other(version)
            if version == 0:
                self._db.executescript(f"BEGIN; {CREATE} PRAGMA user_version={SCHEMA}; COMMIT;")
            if not has_our_tables(self._db):
                raise self.damaged("its tables are not those of a ledger")
            found = self._db.execute("PRAGMA integrity_check(1)").fetchone()
            if found != ("ok",):
                raise self.damaged(found[0] if found else "its structure is broken")
        except (*BROKEN, DamageError) as error:
            self._open.close()
            raise self._failure(error) from None
        except RoboMoReError:
            self._open.close()
            raise

    def close(self) -> None:
        # Not while another thread is writing.
        with self._lock:
            self._open.close()

    def damaged(self, reason: object) -> LedgerDamaged:
        """Return what is said where the file is not what was written."""
        return LedgerDamaged(
            f"the ledger {self._path} is damaged ({one_line(str(reason))}); start its run again "
            "with the same command, which keeps every row that is whole and does the rest again"
        )

    def _foreign(self, what: str) -> LedgerError:
        return LedgerError(
            f"the ledger {self._path} holds a {one_line(what)}, which no RoboMoRe wrote and which "
            "could run whatever its author wanted; do not use this run folder"
        )

    def restore(self, table: str, row: tuple[Any, ...]) -> None:
        """Write one row that has its time and digest already."""
        places = ", ".join("?" * len(row))
        self._execute(f"INSERT OR REPLACE INTO {table} VALUES ({places})", row)

    def _too_large(self, limit: str) -> LedgerError:
        return LedgerError(
            f"the ledger {self._path} holds more than {limit}, which no run writes; do not use "
            "this run folder"
        )

    def _refuse_other(self, version: int) -> None:
        if version > SCHEMA:
            raise LedgerError(
                f"{self._path} has version {version}, this RoboMoRe reads up to {SCHEMA}; "
                "install a newer RoboMoRe"
            )
        if version != 0 and version < SCHEMA:
            raise LedgerError(
                f"{self._path} has version {version}, this RoboMoRe reads {SCHEMA}; install "
                "the RoboMoRe that wrote it, or start anew with another --out"
            )

    def _insert(self, table: str, *columns: Any) -> None:
        """Write one row, in the place of one with the same key; time and digest are added."""
        row = (*columns, time.time())
        self.restore(table, (*row, digest(row)))

    def _append(self, table: str, *columns: Any) -> None:
        """Write one row under the table's next `seq`, whichever other connection writes as well."""
        try:
            with self._lock, self._db:
                self._db.execute("BEGIN IMMEDIATE")
                last = self._db.execute(f"SELECT coalesce(max(seq), 0) FROM {table}").fetchone()[0]
                row = (last + 1, *columns, time.time())
                places = ", ".join("?" * (len(row) + 1))
                self._db.execute(f"INSERT INTO {table} VALUES ({places})", (*row, digest(row)))
        except BROKEN as error:
            raise self._failure(error) from None

    def _select(self, query: str, values: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
        """Yield the rows of a `SELECT *`, without their digests, once those have been checked."""
        for *row, expected in self._execute(query, values):
            if digest(row) != expected:
                raise self.damaged("a row does not match its digest")
            yield tuple(row)

    def _decode(self, body: bytes | str, kind: type[T]) -> T:
        if isinstance(body, bytes | str):  # a damaged row can hold anything
            self._read += body.count(b",") if isinstance(body, bytes) else body.count(",")
        if self._read > MOST_NUMBERS:
            raise self._too_large(f"{MOST_NUMBERS:,} values")
        try:
            return msgspec.json.decode(body, type=kind)
        except (ValueError, TypeError, RecursionError) as error:
            raise self.damaged(error) from None

    def _execute(self, query: str, values: tuple[Any, ...] = ()) -> list[Any]:
        try:
            with self._lock, self._db:
                rows, size = [], 0
                for row in self._db.execute(query, values):
                    size += sum(len(one) for one in row if isinstance(one, bytes | str))
                    if size > MOST_BYTES:
                        raise self._too_large(f"{MOST_BYTES:,} bytes")
                    rows.append(row)
                return rows
        except BROKEN as error:
            raise self._failure(error) from None

    def _failure(self, error: Exception) -> RoboMoReError:
        """Tell damage from a disk that is full, or a medium that cannot be written."""
        code = getattr(error, "sqlite_errorcode", None)
        if code is None or code in DAMAGE or code & 0xFF in DAMAGE:
            return self.damaged(error)
        return StorageFailed(
            f"the ledger {self._path} cannot be used now ({one_line(str(error))}); free disk space "
            "or make the folder writable, then the same command goes on: everything that was "
            "finished is kept"
        )


def digest(columns: Iterable[Any]) -> bytes:
    """Return what stands last in a row: the first half of the SHA-256 of its other columns.

    Each is preceded by its length, so that no two rows have one text.
    """
    text = hashlib.sha256()
    for column in columns:
        part = column if isinstance(column, bytes) else repr(column).encode()
        text.update(len(part).to_bytes(8, "little") + part)
    return text.digest()[:16]
