"""The only way to a model: it pays for nothing twice, loses no answer, and keeps to a budget."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from functools import partial

from robomore.errors import BudgetExhausted, InputError
from robomore.llm.exchange import Exchange, ExchangeLog, Spending, exchange_key
from robomore.llm.model import ChatModel, Request
from robomore.llm.tokens import estimate_prompt
from robomore.llm.trouble import prompt_cut
from robomore.types import Slot

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class ModelBudget:
    """What a whole run may spend on a model, over all interruptions. `None` is no limit.

    Attributes:
        requests: requests that are sent, failed ones included. This limit is never passed.
        tokens: input and output tokens. The prompt is counted before it is sent, so one answer (or
            one answer of each parallel request) can pass the limit.
        cost: in US dollars. It is kept like `tokens`.
    """

    requests: int | None = None
    tokens: int | None = None
    cost: float | None = None


class BudgetedClient:
    """A model with a log of all exchanges and a budget. Several threads may use it at once."""

    def __init__(
        self,
        model: ChatModel,
        log: ExchangeLog,
        budget: ModelBudget | None = None,
        watch: Callable[[Spending], None] = lambda spent: None,
        waits: Callable[[Slot, bool], None] = lambda slot, waiting: None,
    ) -> None:
        """Make a client.

        Args:
            model: the model that answers.
            log: where exchanges are kept.
            budget: what may be spent, by default without limits.
            watch: is called after each answer with what was spent so far, from any thread.
            waits: is called from any thread when an answer begins to be waited for (`True`), and
                when it is there or will not come (`False`).

        Raises:
            InputError: the budget limits the cost of a model without a known price.
        """
        self._model = model
        self._log = log
        self._watch = watch
        self._waits = waits
        self._budget = budget or ModelBudget()
        self._pending: list[_PendingRequest] = []
        self._cut_seen = False
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

    def ask(self, request: Request) -> Exchange:
        """Return the exchange of `request` from the log, or ask the model and log the exchange.

        Raises:
            BudgetExhausted: the budget does not allow another request.
            InputError: the request can never succeed.
            ModelUnavailable: the model did not answer.
        """
        key = exchange_key(self._model.name, request)
        with self._lock:
            kept = self._log.find(key)
        if kept is not None:
            return kept
        with self._reserved(request) as pending:
            completion = self._model.complete(request, partial(self._send, pending))
            # JSON can hold a lone surrogate, which UTF-8 cannot encode.
            reply = completion.reply.encode("utf-8", "replace").decode("utf-8")
            exchange = Exchange(
                **asdict(replace(completion, reply=reply)),
                key=key,
                slot=request.slot,
                repair=request.repair,
                model=self._model.name,
                messages=request.messages,
                sampling=request.sampling,
            )
            # The exchange is logged before anything else can fail, so nobody pays for it again.
            with self._lock:
                self._log.add(exchange)
                spent = self._log.spent()
        cut = prompt_cut(request.messages, completion.input_tokens)
        if cut and not self._cut_seen:
            self._cut_seen = True
            _log.warning("%s: %s", self._model.name, cut)
        self._watch(spent)
        _log.info(
            f"{exchange.model} answered {request.slot} in {exchange.seconds:.1f} s "
            f"({exchange.input_tokens} + {exchange.output_tokens} tokens)"
        )
        return exchange

    def set_errors(self, exchange: Exchange, errors: Sequence[str]) -> None:
        """Log the validation errors of an exchange's reply, none for an accepted reply."""
        if exchange.validation_errors != tuple(errors):
            with self._lock:
                self._log.set_errors(exchange.key, errors)

    @contextmanager
    def _reserved(self, request: Request) -> Iterator[_PendingRequest]:
        """Count the prompt as spent until the answer is there, so that parallel requests see it."""
        prompt = estimate_prompt(request.messages)
        pending = _PendingRequest(request, prompt, self._model.cost(prompt, 0) or 0.0)
        with self._lock:
            self._check(pending)
            self._pending.append(pending)
        self._waits(request.slot, True)
        try:
            yield pending
        finally:
            with self._lock:
                self._pending.remove(pending)
            self._waits(request.slot, False)

    def _send(self, pending: _PendingRequest) -> None:
        """Log that a request is being sent, or raise `BudgetExhausted`.

        It is logged before it is sent, so that a request without an answer is counted too.
        """
        with self._lock:
            self._check(pending)
            self._log.sent(pending.request)

    def _check(self, pending: _PendingRequest) -> None:
        spent = self._log.spent()
        planned = [pending, *(other for other in self._pending if other is not pending)]
        tokens = spent.tokens + sum(one.tokens for one in planned)
        cost = spent.cost + sum(one.cost for one in planned)
        for option, limit, total, unit in (
            ("--max-requests", self._budget.requests, spent.requests + 1, "requests"),
            ("--max-tokens", self._budget.tokens, tokens, "tokens"),
            ("--max-cost", self._budget.cost, cost, "dollars"),
        ):
            if limit is not None and total > limit:
                raise BudgetExhausted(
                    f"the budget of {limit:g} {unit} does not allow another request (so far: "
                    f"{spent.requests} requests, {spent.tokens} tokens, ${spent.cost:.2f}); "
                    f"nothing is lost: run the same command with a larger {option} to go on"
                )


@dataclass(frozen=True, slots=True, eq=False)
class _PendingRequest:
    """A request without an answer yet, and what its prompt takes in tokens and US dollars."""

    request: Request
    tokens: int
    cost: float
