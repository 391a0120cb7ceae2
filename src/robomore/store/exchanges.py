"""The exchanges of a run, kept in its ledger file before anybody reads them."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Sequence
from pathlib import Path

import msgspec

from robomore.llm.exchange import Exchange, Spending
from robomore.llm.model import Request
from robomore.store.ledger import SCHEMA
from robomore.store.rows import Rows


class LedgerExchanges(Rows):
    """An `ExchangeLog` in a ledger that exists already. May be used from several threads.

    It has a connection of its own, whose commits reach the disk before they return: an answer that
    was paid for survives a power cut, while evaluations can be done again.
    """

    def __init__(self, path: Path, read_only: bool = False) -> None:
        """Open the exchanges in the ledger at `path`.

        Raises:
            LedgerError: damaged, or of a newer version.
        """
        super().__init__(path, SCHEMA, read_only, durable=True)
        self._spent: Spending | None = None
        self._sent = 0

    def find(self, key: str) -> Exchange | None:
        """Return the exchange of that key."""
        return self._read("SELECT body, digest FROM exchanges WHERE key = ?", key, Exchange)

    def sent(self, request: Request) -> None:
        """Count a request that is about to be sent; the count is on the disk once this returns."""
        body = msgspec.json.encode({"slot": request.slot, "repair": request.repair})
        with self._lock:
            self.spent()
            self._execute(
                "INSERT INTO events (kind, body, time) VALUES ('sent', ?, ?)", (body, time.time())
            )
            self._sent += 1

    def add(self, exchange: Exchange) -> None:
        """Keep a new exchange; it is on the disk once this returns."""
        with self._lock:
            self.spent()
            self._write(
                "INSERT OR REPLACE INTO exchanges VALUES (?, ?, ?, ?)", exchange.key, exchange
            )
            assert self._spent is not None
            self._spent += Spending.of([exchange])

    def judge(self, key: str, findings: Sequence[str]) -> None:
        """Set the findings of a kept exchange.

        Raises:
            KeyError: there is none of that key.
        """
        with self._lock:
            kept = self.find(key)
            if kept is None:
                raise KeyError(key)
            judged = dataclasses.replace(kept, findings=tuple(findings))
            self._write(
                "UPDATE exchanges SET body = ?2, digest = ?3, time = coalesce(time, ?4) "
                "WHERE key = ?1",
                key,
                judged,
            )

    def all(self) -> list[Exchange]:
        """Return all exchanges, oldest first."""
        return list(self._all("SELECT body, digest FROM exchanges ORDER BY rowid", Exchange))

    def spent(self) -> Spending:
        """Return what all exchanges took together, in earlier processes too.

        Requests are counted as they were sent: a process that was killed, or a model that never
        answered, leaves more of them than exchanges tell of.
        """
        with self._lock:
            if self._spent is None:
                self._spent = Spending.of(self.all())
                counted = self._execute("SELECT count(*) FROM events WHERE kind = 'sent'")
                self._sent = int(counted[0][0])
            return self._spent.sent(self._sent)
