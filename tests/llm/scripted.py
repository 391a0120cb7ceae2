"""A language model that is a list of answers, and logs that fail when they are told to."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence

from robomore.llm import Completion, Exchange, MemoryLog, Request
from robomore.llm.model import do_nothing


class ScriptedModel:
    """Answers from a list, or by a function of the request; remembers what it was asked."""

    def __init__(
        self,
        answers: Sequence[str | Completion] | Callable[[Request], str | Completion],
        name: str = "fake",
        price: float | None = 0.01,
    ) -> None:
        self.name = name
        self.asked: list[Request] = []
        self._answers = answers
        self._price = price
        self._lock = threading.Lock()

    def complete(
        self, request: Request, before_send: Callable[[], None] = do_nothing
    ) -> Completion:
        before_send()
        with self._lock:
            number = len(self.asked)
            self.asked.append(request)
        text = self._answers(request) if callable(self._answers) else self._answers[number]
        if isinstance(text, Completion):
            return text
        return Completion(text, input_tokens=1000, output_tokens=100, cost=self._price)

    def cost(self, input_tokens: int, output_tokens: int) -> float | None:
        return None if self._price is None else 0.0


class Killed(BaseException):
    """The process dies here."""


class DyingLog(MemoryLog):
    """Dies at a certain call, before or after it has done its work."""

    def __init__(self, kept: Sequence[Exchange], call: str, number: int, after: bool) -> None:
        super().__init__(kept)
        self._plan = (call, number, after)
        self._calls = {"add": 0, "set_errors": 0}

    def add(self, exchange: Exchange) -> None:
        self._dying("add", lambda: super(DyingLog, self).add(exchange))

    def set_errors(self, key: str, errors: Sequence[str]) -> None:
        self._dying("set_errors", lambda: super(DyingLog, self).set_errors(key, errors))

    def _dying(self, call: str, work: Callable[[], None]) -> None:
        self._calls[call] += 1
        planned, number, after = self._plan
        due = call == planned and self._calls[call] == number
        if due and not after:
            raise Killed
        work()
        if due:
            raise Killed
