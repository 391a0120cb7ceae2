"""Exchanges with a model: the request, the answer, its cost, and the errors found in it."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from robomore.identity import content_key
from robomore.llm.model import Completion, Message, Request, Sampling
from robomore.types import Slot


@dataclass(frozen=True, slots=True, kw_only=True)
class Exchange(Completion):
    """A completion with what was asked, as the ledger keeps it.

    `key` is the content key (`exchange_key`) of the model's name and of the `Request`, whose fields
    are the others.
    """

    key: str
    slot: Slot
    repair: int
    model: str
    messages: tuple[Message, ...]
    sampling: Sampling


@dataclass(frozen=True, slots=True)
class Spending:
    """What a number of exchanges took in all.

    Attributes:
        requests: requests that were sent, those that failed included.
        tokens: input and output tokens.
        cost: in US dollars, of the exchanges with a known price.
        unpriced: number of exchanges without a known price.
    """

    requests: int = 0
    tokens: int = 0
    cost: float = 0.0
    unpriced: int = 0

    @classmethod
    def of(cls, exchanges: Iterable[Exchange]) -> Spending:
        """Return the sum over `exchanges`."""
        each = [
            cls(e.tries, e.input_tokens + e.output_tokens, e.cost or 0.0, int(e.cost is None))
            for e in exchanges
        ]
        return sum(each, cls())

    def sent(self, requests: int) -> Spending:
        """Return the same spending with the requests that were sent, answered or not."""
        return replace(self, requests=max(self.requests, requests))

    def __add__(self, other: Spending) -> Spending:
        """Return the sum of both."""
        return Spending(
            self.requests + other.requests,
            self.tokens + other.tokens,
            self.cost + other.cost,
            self.unpriced + other.unpriced,
        )


class ExchangeLog(Protocol):
    """Keeps exchanges. `BudgetedClient` calls it under one lock, but from several threads."""

    def find(self, key: str) -> Exchange | None:
        """Return the exchange with that key, or `None`."""
        ...

    def sent(self, request: Request) -> None:
        """Count a request that is about to be sent, whether or not an answer comes."""
        ...

    def add(self, exchange: Exchange) -> None:
        """Keep a new exchange. It survives a killed process as soon as this returns."""
        ...

    def set_errors(self, key: str, errors: Sequence[str]) -> None:
        """Set the validation errors of the exchange with that key."""
        ...

    def all(self) -> Sequence[Exchange]:
        """Return all exchanges, oldest first."""
        ...

    def spent(self) -> Spending:
        """Return what all exchanges took, requests without an answer included."""
        ...


class MemoryLog:
    """An `ExchangeLog` in memory."""

    def __init__(self, exchanges: Iterable[Exchange] = ()) -> None:
        self._exchanges = {exchange.key: exchange for exchange in exchanges}
        self._sent = sum(exchange.tries for exchange in self._exchanges.values())
        self._lock = threading.Lock()

    def find(self, key: str) -> Exchange | None:
        return self._exchanges.get(key)

    def sent(self, request: Request) -> None:
        with self._lock:
            self._sent += 1

    def add(self, exchange: Exchange) -> None:
        with self._lock:
            self._exchanges[exchange.key] = exchange

    def set_errors(self, key: str, errors: Sequence[str]) -> None:
        with self._lock:
            kept = self._exchanges[key]
            self._exchanges[key] = replace(kept, validation_errors=tuple(errors))

    def all(self) -> list[Exchange]:
        return list(self._exchanges.values())

    def spent(self) -> Spending:
        return Spending.of(self._exchanges.values()).sent(self._sent)


def exchange_key(model: str, request: Request) -> str:
    """Return the content key under which the answer to `request` is kept.

    The key leaves out pictures: two machines draw the same morphology with slightly different
    pixels, and the text says what the pictures show. It also leaves out the schema, which follows
    from the task.
    """
    said = [(message.role, message.text) for message in request.messages]
    return content_key("exchange", request.slot, request.repair, model, request.sampling, said)
