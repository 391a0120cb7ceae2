"""Exchanges: what was asked, what was answered, what it cost, and what was wrong with it."""

from __future__ import annotations

import dataclasses
import threading
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from robomore.identity import content_key
from robomore.llm.model import Message, Request, Sampling
from robomore.types import Slot


@dataclass(frozen=True, slots=True)
class Exchange:
    """One request that was answered, as it stands in the ledger.

    Attributes:
        key: content key of slot, repair, model, sampling and messages.
        slot: which proposal it was for.
        repair: 0, or how many answers in the same slot were sent back before.
        model: the model's name.
        messages: all that was sent.
        sampling: settings of the answer.
        reply: the answer, as it came.
        truncated: the provider cut it off.
        input_tokens: counted by the provider, or an estimate.
        output_tokens: likewise.
        cost: in US dollars; `None` where no price is known.
        seconds: it took.
        tries: requests sent until one succeeded; 0 for a recording.
        structured: the provider enforced the schema.
        findings: what was wrong with the reply: empty if it was accepted, `None` while nobody has
            judged it.
    """

    key: str
    slot: Slot
    repair: int
    model: str
    messages: tuple[Message, ...]
    sampling: Sampling
    reply: str
    truncated: bool = False
    input_tokens: int = 0
    output_tokens: int = 0
    cost: float | None = None
    seconds: float = 0.0
    tries: int = 1
    structured: bool = False
    findings: tuple[str, ...] | None = None


@dataclass(frozen=True, slots=True)
class Spending:
    """What exchanges took together.

    Attributes:
        requests: answered, and tried in vain on the way.
        tokens: in and out.
        cost: in US dollars, of the exchanges whose price is known.
        unpriced: exchanges whose price is not known.
    """

    requests: int = 0
    tokens: int = 0
    cost: float = 0.0
    unpriced: int = 0

    @classmethod
    def of(cls, exchanges: Iterable[Exchange]) -> Spending:
        """Return the sum over `exchanges`."""
        requests = tokens = unpriced = 0
        cost = 0.0
        for exchange in exchanges:
            requests += exchange.tries
            tokens += exchange.input_tokens + exchange.output_tokens
            cost += exchange.cost or 0.0
            unpriced += exchange.cost is None
        return cls(requests, tokens, cost, unpriced)

    def sent(self, requests: int) -> Spending:
        """Return the same with all requests that were sent, if some were never answered."""
        return replace(self, requests=max(self.requests, requests))

    def __add__(self, other: Spending) -> Spending:
        """Return both together."""
        return Spending(
            self.requests + other.requests,
            self.tokens + other.tokens,
            self.cost + other.cost,
            self.unpriced + other.unpriced,
        )


class ExchangeLog(Protocol):
    """Remembers exchanges. Called under one lock, but from whichever thread asks a model."""

    def find(self, key: str) -> Exchange | None:
        """Return the exchange of that key."""
        ...

    def sent(self, request: Request) -> None:
        """Count a request that is about to be sent, whatever becomes of it."""
        ...

    def add(self, exchange: Exchange) -> None:
        """Keep a new exchange; it survives the process being killed once this returns."""
        ...

    def judge(self, key: str, findings: Sequence[str]) -> None:
        """Set the findings of a kept exchange."""
        ...

    def all(self) -> Sequence[Exchange]:
        """Return all exchanges, oldest first."""
        ...

    def spent(self) -> Spending:
        """Return what all exchanges took together, and requests that were never answered."""
        ...


class MemoryLog:
    """An `ExchangeLog` that lasts as long as the process."""

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

    def judge(self, key: str, findings: Sequence[str]) -> None:
        with self._lock:
            kept = self._exchanges[key]
            self._exchanges[key] = dataclasses.replace(kept, findings=tuple(findings))

    def all(self) -> list[Exchange]:
        return list(self._exchanges.values())

    def spent(self) -> Spending:
        return Spending.of(self._exchanges.values()).sent(self._sent)


def exchange_key(model: str, request: Request) -> str:
    """Return the key under which the answer to `request` is kept.

    Pictures are left out: two machines draw the same body in slightly different pixels, and what
    they show stands in the text as well. So is the schema, which follows from the task.
    """
    said = [(message.role, message.text) for message in request.messages]
    return content_key("exchange", request.slot, request.repair, model, request.sampling, said)
