"""The one way to a model: nothing is paid twice, nothing is lost, and a budget is kept."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial

from robomore.errors import BudgetExhausted, InputError
from robomore.llm.exchange import Exchange, ExchangeLog, Spending, exchange_key
from robomore.llm.model import ChatModel, Request
from robomore.llm.tokens import estimate_prompt

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class ModelBudget:
    """What a run may spend on a model in all, interruptions included. `None` is no limit.

    Attributes:
        requests: sent, those in vain included; kept to the last one.
        tokens: in and out. The prompt's estimate is counted before it is sent, so the limit can be
            passed by the length of an answer at most (of each answer under way).
        cost: in US dollars; kept like `tokens`.
    """

    requests: int | None = None
    tokens: int | None = None
    cost: float | None = None


class BudgetedClient:
    """A model, the log of what was said to it, and a budget."""

    def __init__(
        self,
        model: ChatModel,
        log: ExchangeLog,
        budget: ModelBudget | None = None,
        watch: Callable[[Spending], None] = lambda spent: None,
    ) -> None:
        """Make the one way to a model.

        Args:
            model: that is asked.
            log: where exchanges are kept.
            budget: that may be spent; without limits by default.
            watch: told after each answer what has been spent so far, from any thread.

        Raises:
            InputError: a cost limit for a model whose price nobody knows.
        """
        self._model = model
        self._log = log
        self._watch = watch
        self._budget = budget or ModelBudget()
        self._under_way: list[_Asking] = []
        self._lock = threading.Lock()
        if self._budget.cost is not None and model.cost(1000, 1000) is None:
            raise InputError(
                f"no price is known for {model.name}, so a limit of ${self._budget.cost:g} cannot "
                "be kept; give its price (--price IN,OUT in dollars per million tokens) or limit "
                "--max-tokens"
            )

    @property
    def model(self) -> ChatModel:
        return self._model

    def spent(self) -> Spending:
        """Return what the run has spent so far."""
        with self._lock:
            return self._log.spent()

    def ask(self, request: Request) -> Exchange:
        """Return the exchange of `request`: the kept one, or a new one that is kept at once.

        Raises:
            BudgetExhausted: the budget does not allow another request.
            InputError: the model can never be asked like this.
            ModelUnavailable: the model did not answer.
        """
        key = exchange_key(self._model.name, request)
        with self._lock:
            kept = self._log.find(key)
        if kept is not None:
            return kept
        with self._reserved(request) as asking:
            completion = self._model.complete(request, partial(self._send, asking))
            exchange = Exchange(
                key=key,
                slot=request.slot,
                repair=request.repair,
                model=self._model.name,
                messages=request.messages,
                sampling=request.sampling,
                # A lone surrogate can come out of any JSON and goes into no UTF-8 file.
                reply=completion.text.encode("utf-8", "replace").decode("utf-8"),
                truncated=completion.truncated,
                input_tokens=completion.input_tokens,
                output_tokens=completion.output_tokens,
                cost=completion.cost,
                seconds=completion.seconds,
                tries=completion.tries,
                structured=completion.structured,
                findings=completion.verdict,
            )
            # Kept before anybody reads it: whatever happens next, it is not paid for again.
            with self._lock:
                self._log.add(exchange)
                spent = self._log.spent()
        self._watch(spent)
        _log.info(
            "%s answered %s in %.1f s (%d + %d tokens)",
            exchange.model,
            request.slot,
            exchange.seconds,
            exchange.input_tokens,
            exchange.output_tokens,
        )
        return exchange

    def judge(self, exchange: Exchange, findings: Sequence[str]) -> None:
        """Write down what was wrong with an exchange's reply; nothing if it was accepted."""
        if exchange.findings != tuple(findings):
            with self._lock:
                self._log.judge(exchange.key, findings)

    @contextmanager
    def _reserved(self, request: Request) -> Iterator[_Asking]:
        """Count a prompt as spent while it is under way, so that parallel ones see it."""
        prompt = estimate_prompt(request.messages)
        asking = _Asking(request, prompt, self._model.cost(prompt, 0) or 0.0)
        with self._lock:
            self._check(asking)
            self._under_way.append(asking)
        try:
            yield asking
        finally:
            with self._lock:
                self._under_way.remove(asking)

    def _send(self, asking: _Asking) -> None:
        """Write down that a request is being sent, or refuse it.

        Written before it is sent, so that one in vain is counted whatever ends it.
        """
        with self._lock:
            self._check(asking)
            self._log.sent(asking.request)

    def _check(self, asking: _Asking) -> None:
        spent = self._log.spent()
        others = [other for other in self._under_way if other is not asking]
        planned = [asking, *others]
        for option, limit, total, what in (
            ("--max-requests", self._budget.requests, spent.requests + 1, "requests"),
            (
                "--max-tokens",
                self._budget.tokens,
                spent.tokens + sum(one.tokens for one in planned),
                "tokens",
            ),
            (
                "--max-cost",
                self._budget.cost,
                spent.cost + sum(one.cost for one in planned),
                "dollars",
            ),
        ):
            if limit is not None and total > limit:
                raise BudgetExhausted(
                    f"the budget of {limit:g} {what} does not allow another request (so far: "
                    f"{spent.requests} requests, {spent.tokens} tokens, ${spent.cost:.2f}); "
                    f"nothing is lost: run the same command with a larger {option} to go on"
                )


@dataclass(frozen=True, slots=True, eq=False)
class _Asking:
    """A request under way: what its prompt takes at least."""

    request: Request
    tokens: int
    cost: float
