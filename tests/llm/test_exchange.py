"""Exchanges are found again, counted, bounded, and replayed."""

from __future__ import annotations

import dataclasses
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scripted import ScriptedModel

from robomore.errors import BudgetExhausted, InputError, ModelUnavailable, ProposalFailed
from robomore.llm import (
    BudgetedClient,
    Completion,
    Exchange,
    MemoryLog,
    Message,
    ModelBudget,
    ReplayModel,
    Request,
    Sampling,
    Spending,
    exchange_key,
)
from robomore.llm.model import do_nothing
from robomore.llm.retry import RetryPolicy, TransientError, retry
from robomore.llm.tokens import estimate_prompt, estimate_tokens
from robomore.types import Slot

SLOT = Slot("coarse", "morphology", (0,))


def request(text: str = "hello", slot: Slot = SLOT, repair: int = 0, **changes) -> Request:
    return Request(slot, repair, (Message("user", text),), **changes)


def test_the_same_request_is_paid_for_once() -> None:
    model, log = ScriptedModel(["one", "two"]), MemoryLog()
    first = BudgetedClient(model, log).ask(request())
    again = BudgetedClient(model, log).ask(request())  # a resumed run
    assert first == again and first.reply == "one"
    assert len(model.asked) == 1 and log.spent() == Spending(1, 1100, 0.01, 0)


@pytest.mark.parametrize(
    "other",
    [
        request("hello", dataclasses.replace(SLOT, index=(1,))),
        request("hello", dataclasses.replace(SLOT, improves=True)),
        request("hello", dataclasses.replace(SLOT, attempt=1)),
        request("hello", dataclasses.replace(SLOT, stage="fine")),
        request("hello", dataclasses.replace(SLOT, kind="reward")),
        request("hello", repair=1),
        request("hello!"),
        request(sampling=Sampling(temperature=0.5)),
    ],
)
def test_what_makes_two_exchanges(other: Request) -> None:
    assert exchange_key("m", request()) != exchange_key("m", other)


def test_what_does_not_change_an_exchange() -> None:
    pictured = Request(SLOT, 0, (Message("user", "hello", (b"png",)),))
    assert exchange_key("m", request()) == exchange_key("m", pictured)
    assert exchange_key("m", request()) == exchange_key("m", request(schema={"type": "object"}))
    assert exchange_key("m", request()) != exchange_key("n", request())


def test_an_exchange_is_kept_before_anybody_reads_it_and_checked_later() -> None:
    log = MemoryLog()
    client = BudgetedClient(ScriptedModel(["one"]), log)
    exchange = client.ask(request())
    assert log.all()[0].validation_errors is None
    client.set_errors(exchange, ["too long"])
    assert log.all()[0].validation_errors == ("too long",)


def test_an_exchange_survives_json_whatever_the_model_says() -> None:
    log = MemoryLog()
    said = "a\ud800b\x00\x1b[31m\u202e\U0001f916"
    exchange = BudgetedClient(ScriptedModel([said]), log).ask(
        Request(SLOT, 0, (Message("user", "look", (b"\x89PNG",)),))
    )
    assert "a?b" in exchange.reply
    assert msgspec.json.decode(msgspec.json.encode(exchange), type=Exchange) == exchange


@pytest.mark.parametrize(
    ("budget", "option", "answered"),
    [
        (ModelBudget(requests=3), "--max-requests", 3),
        (ModelBudget(tokens=3000), "--max-tokens", 3),
        (ModelBudget(cost=0.025), "--max-cost", 3),
        (ModelBudget(requests=0), "--max-requests", 0),
    ],
)
def test_a_budget_stops_and_survives_resume(
    budget: ModelBudget, option: str, answered: int
) -> None:
    log = MemoryLog()
    model = ScriptedModel(lambda asked: "fine")
    for _ in range(2):  # the second time is a resumed run
        client = BudgetedClient(model, log, budget)
        with pytest.raises(BudgetExhausted, match=option):
            for number in range(10):
                client.ask(request(str(number)))
        assert len(model.asked) == answered
    assert log.spent().requests == answered


def test_a_kept_exchange_is_free_even_when_the_budget_is_spent() -> None:
    model, log = ScriptedModel(["one"]), MemoryLog()
    client = BudgetedClient(model, log, ModelBudget(requests=1))
    assert client.ask(request()) == client.ask(request())


def test_requests_side_by_side_do_not_pass_the_budget() -> None:
    barrier = threading.Barrier(3, timeout=10)

    def slow(asked: Request) -> str:
        barrier.wait()
        return "fine"

    log = MemoryLog()
    client = BudgetedClient(ScriptedModel(slow), log, ModelBudget(requests=3))
    stopped = []

    def ask(number: int) -> None:
        try:
            client.ask(request(str(number)))
        except BudgetExhausted:
            stopped.append(number)

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(ask, range(8)))
    assert len(stopped) == 5 and log.spent().requests == 3


def test_a_prompt_that_the_budget_cannot_pay_for_is_not_sent() -> None:
    long = request("word " * 500)
    model, log = ScriptedModel(["fine"]), MemoryLog()
    few = ModelBudget(tokens=estimate_prompt(long.messages) - 1)
    with pytest.raises(BudgetExhausted, match="--max-tokens"):
        BudgetedClient(model, log, few).ask(long)
    assert not model.asked and not log.spent().requests


def test_prompts_under_way_count_against_the_tokens() -> None:
    answering, waiting = threading.Event(), threading.Event()

    def slow(asked: Request) -> str:
        waiting.set()
        answering.wait(10)
        return "fine"

    model = ScriptedModel(slow)
    one = estimate_prompt(request("0").messages)
    client = BudgetedClient(model, MemoryLog(), ModelBudget(tokens=2 * one - 1))
    with ThreadPoolExecutor(1) as pool:
        first = pool.submit(client.ask, request("0"))
        assert waiting.wait(10)
        with pytest.raises(BudgetExhausted, match="--max-tokens"):
            client.ask(request("1"))
        answering.set()
        assert first.result().reply == "fine"
    assert len(model.asked) == 1


def test_a_cost_limit_without_a_price_is_refused() -> None:
    with pytest.raises(InputError, match="--price"):
        BudgetedClient(ScriptedModel([], price=None), MemoryLog(), ModelBudget(cost=1.0))


def test_a_failed_request_leaves_nothing_under_way() -> None:
    class Down(ScriptedModel):
        def complete(
            self, asked: Request, before_send: Callable[[], None] = do_nothing
        ) -> Completion:
            before_send()
            raise ModelUnavailable("down")

    budget = ModelBudget(requests=3, tokens=estimate_prompt(request().messages))
    client = BudgetedClient(Down([]), MemoryLog(), budget)
    for _ in range(3):
        with pytest.raises(ModelUnavailable):
            client.ask(request())
    # They were sent all the same.
    with pytest.raises(BudgetExhausted, match="so far: 3 requests, 0 tokens"):
        client.ask(request())


def recorded(*texts: str) -> MemoryLog:
    log = MemoryLog()
    client = BudgetedClient(ScriptedModel([f"to {text}" for text in texts]), log)
    for number, text in enumerate(texts):
        exchange = client.ask(request(text, dataclasses.replace(SLOT, index=(number,))))
        client.set_errors(exchange, [f"error {number}"])
    return log


def test_a_replay_answers_the_same_and_costs_nothing() -> None:
    log = recorded("a", "b")
    own = MemoryLog()
    replay = BudgetedClient(ReplayModel(log), own)
    asked = request("b", dataclasses.replace(SLOT, index=(1,)))
    answered = replay.ask(asked)
    original = log.all()[1]
    assert answered.key == original.key
    assert (answered.reply, answered.validation_errors) == ("to b", ("error 1",))
    assert own.spent() == Spending()
    # A replay can be replayed.
    assert ReplayModel(own).complete(asked).reply == "to b"


def test_a_replay_says_where_it_parts_from_the_recording() -> None:
    replay = ReplayModel(recorded("a"))
    with pytest.raises(InputError, match="another prompt for coarse morphology 1"):
        replay.complete(request("other"))
    with pytest.raises(InputError, match="ends before coarse morphology 6"):
        replay.complete(request("a", dataclasses.replace(SLOT, index=(5,))))
    with pytest.raises(InputError, match="no exchanges"):
        ReplayModel(MemoryLog())


def test_a_replay_by_slot_has_no_proposal_for_further_improvements() -> None:
    replay = ReplayModel(recorded("a"), by="slot")
    further = dataclasses.replace(SLOT, index=(5,), improves=True)
    with pytest.raises(ProposalFailed, match="no answer for coarse morphology 6"):
        replay.complete(request("a", further))
    with pytest.raises(InputError, match="ends before coarse morphology 6"):
        replay.complete(request("a", dataclasses.replace(further, improves=False)))


def test_a_replay_by_slot_takes_any_prompt_and_is_checked_again() -> None:
    replay = ReplayModel(recorded("a"), by="slot")
    completion = replay.complete(request("the history has other numbers now"))
    assert (completion.reply, completion.validation_errors) == ("to a", None)


def test_retries_are_bounded_and_wait_longer_each_time() -> None:
    waits: list[float] = []

    def fails() -> None:
        raise TransientError("busy")

    with pytest.raises(ModelUnavailable, match="tried 4 times"):
        retry(fails, RetryPolicy(max_tries=4, initial_wait=1, max_wait=3), waits.append)
    assert len(waits) == 3
    assert 0.75 <= waits[0] <= 1.25 and 1.5 <= waits[1] <= 2.5 and 2.25 <= waits[2] <= 3.75


@given(st.text(), st.text())
def test_token_estimates_grow_with_the_text(a: str, b: str) -> None:
    assert estimate_tokens(a + b) >= max(estimate_tokens(a), estimate_tokens(b))
    assert estimate_prompt([Message("user", a)]) > estimate_tokens(a)
