"""Rows of JSON in one SQLite file, each with a digest: damage is found and never believed."""

from __future__ import annotations

import hashlib
import sqlite3
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from robomore.errors import LedgerError

_PATIENCE_SECONDS = 60.0
"""How long one connection of a run waits for another one's commit."""

T = TypeVar("T")


class Rows:
    """A connection to a ledger's file. May be used from several threads."""

    def __init__(self, path: Path, schema: int, read_only: bool, durable: bool) -> None:
        """Open the file at `path`.

        Args:
            path: of the file; made if it is missing.
            schema: the version of its tables that the caller knows.
            read_only: write nothing, not even a new file.
            durable: a commit survives the machine, not only the process.

        Raises:
            LedgerError: damaged, or of a newer version.
        """
        self._path = path
        self._lock = threading.RLock()
        try:
            name = f"{path.absolute().as_uri()}?mode=ro" if read_only else str(path)
            self._db = sqlite3.connect(
                name, timeout=_PATIENCE_SECONDS, uri=read_only, check_same_thread=False
            )
            if not read_only:
                # Readers never wait for the writer, and a commit survives the process being killed.
                self._db.execute("PRAGMA journal_mode=WAL")
                self._db.execute(f"PRAGMA synchronous={'FULL' if durable else 'NORMAL'}")
            (self._version,) = self._db.execute("PRAGMA user_version").fetchone()
        except sqlite3.Error as error:
            raise self._damaged(error) from None
        if self._version > schema:
            raise LedgerError(
                f"{path} has version {self._version}, this RoboMoRe reads up to {schema}; "
                "install a newer RoboMoRe"
            )

    def close(self) -> None:
        # Not while another thread is writing.
        with self._lock:
            self._db.close()

    def _script(self, statements: str) -> None:
        try:
            self._db.executescript(statements)
        except sqlite3.Error as error:
            raise self._damaged(error) from None

    def _write(self, query: str, key: str, value: Any) -> None:
        """Run a query with four places: key, body, digest and time."""
        body = msgspec.json.encode(value)
        self._execute(query, (key, body, digest(body), time.time()))

    def _read(self, query: str, key: str | tuple[str, ...], kind: type[T]) -> T | None:
        rows = self._execute(query, key if isinstance(key, tuple) else (key,))
        return self._checked(rows[0], kind) if rows else None

    def _all(self, query: str, kind: type[T]) -> Iterator[T]:
        return (self._checked(row, kind) for row in self._execute(query))

    def _checked(self, row: tuple[bytes, bytes], kind: type[T]) -> T:
        body, expected = row
        if not isinstance(body, bytes) or digest(body) != expected:
            raise self._damaged("a row does not match its digest")
        return self._decode(body, kind)

    def _decode(self, body: bytes, kind: type[T]) -> T:
        try:
            return msgspec.json.decode(body, type=kind)
        except msgspec.DecodeError as error:
            raise self._damaged(error) from None

    def _execute(self, query: str, values: tuple[Any, ...] = ()) -> list[Any]:
        try:
            with self._lock, self._db:
                return self._db.execute(query, values).fetchall()
        except sqlite3.Error as error:
            raise self._damaged(error) from None

    def _damaged(self, reason: object) -> LedgerError:
        return LedgerError(
            f"the ledger {self._path} cannot be used ({reason}); free disk space if it is full, "
            "restore the file from a copy, or start anew with another --out"
        )


def digest(body: bytes) -> bytes:
    """Return what stands beside a row's body: the first half of its SHA-256."""
    return hashlib.sha256(body).digest()[:16]
