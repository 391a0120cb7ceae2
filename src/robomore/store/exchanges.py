"""The exchanges of a run, kept in its ledger file before anybody reads them."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path

from robomore.llm.exchange import Exchange, Spending
from robomore.llm.model import Request
from robomore.store.rows import Rows, digest
from robomore.text import to_json


class LedgerExchanges(Rows):
    """An `ExchangeLog` in a ledger that exists already. May be used from several threads.

    It has a connection of its own, whose commits reach the disk before they return: an answer that
    was paid for survives a power cut, while evaluations can be done again.
    """

    def __init__(self, path: Path, read_only: bool = False) -> None:
        """Open the exchanges in the ledger at `path`.

        Raises:
            LedgerError: damaged, or of another version.
            StorageFailed: the disk is full, or cannot be written.
        """
        super().__init__(path, read_only, durable=True)
        self._spent: Spending | None = None
        self._sent = 0

    def find(self, key: str) -> Exchange | None:
        """Return the exchange of that key."""
        for _, body, _ in self._select("SELECT * FROM exchanges WHERE key = ?", (key,)):
            return self._decode(body, Exchange)
        return None

    def sent(self, request: Request) -> None:
        """Count a request that is about to be sent; the count is on the disk once this returns."""
        body = to_json({"slot": request.slot, "repair": request.repair})
        with self._lock:
            self.spent()
            self._append("events", "sent", body)
            self._sent += 1

    def add(self, exchange: Exchange) -> None:
        """Keep a new exchange; it is on the disk once this returns."""
        with self._lock:
            self.spent()
            self._insert("exchanges", exchange.key, to_json(exchange))
            assert self._spent is not None
            self._spent += Spending.of([exchange])

    def set_errors(self, key: str, errors: Sequence[str]) -> None:
        """Set the validation errors of a kept exchange.

        Raises:
            KeyError: there is none of that key.
        """
        with self._lock:
            kept = next(self._select("SELECT * FROM exchanges WHERE key = ?", (key,)), None)
            if kept is None:
                raise KeyError(key)
            _, body, at = kept
            exchange = self._decode(body, Exchange)
            checked = dataclasses.replace(exchange, validation_errors=tuple(errors))
            body = to_json(checked)
            # The row keeps its number, and so its place in the order.
            self._execute(
                "UPDATE exchanges SET body = ?, digest = ? WHERE key = ?",
                (body, digest((key, body, at)), key),
            )

    def all(self) -> list[Exchange]:
        """Return all exchanges, oldest first."""
        rows = self._select("SELECT * FROM exchanges ORDER BY rowid")
        return [self._decode(body, Exchange) for _, body, _ in rows]

    def spent(self) -> Spending:
        """Return what all exchanges took together, in earlier processes too.

        Requests are counted as they were sent: a process that was killed, or a model that never
        answered, leaves more of them than exchanges tell of.
        """
        with self._lock:
            if self._spent is None:
                self._spent = Spending.of(self.all())
                sent = self._select("SELECT * FROM events WHERE kind = 'sent'")
                self._sent = sum(1 for _ in sent)
            return self._spent.sent(self._sent)
