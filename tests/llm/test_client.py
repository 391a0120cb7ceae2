"""A real client against a server that misbehaves: progress, or one clear line."""

from __future__ import annotations

import dataclasses
import sys

import pytest
from loopback import KEY, serve

from robomore.errors import InputError, ModelUnavailable
from robomore.llm import Message, Request, Sampling, check, connect
from robomore.llm.providers import COMPATIBLE_KEY
from robomore.llm.retry import RetryPolicy
from robomore.types import Slot

pytest.importorskip("pydantic_ai")

SCHEMA = {
    "title": "check",
    "type": "object",
    "properties": {"length": {"type": "number"}},
    "required": ["length"],
    "additionalProperties": False,
}
PLAIN = Request(
    Slot("coarse", "reward", (0,)), 0, (Message("system", "be brief"), Message("user", "ready?"))
)
FORMED = dataclasses.replace(PLAIN, schema=SCHEMA)


def model_at(url: str, tries: int = 3, seconds: float = 20.0):
    """A model whose waits are noted, not slept."""
    model = connect("toy", base_url=url, retry_policy=RetryPolicy(max_tries=tries, timeout=seconds))
    waits: list[float] = []
    model._sleep = waits.append
    return model, waits


@pytest.fixture(autouse=True)
def key(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(COMPATIBLE_KEY, KEY)


def test_an_answer_comes_with_its_tokens_and_price() -> None:
    with serve("say") as (url, script):
        model, waits = model_at(url)
        completion = model.complete(PLAIN)
    assert (completion.reply, completion.tries, waits) == ("ready", 1, [])
    assert (completion.input_tokens, completion.output_tokens) == (100, 20)
    assert completion.cost == 0.0  # a server on this machine
    assert script.keys == [f"Bearer {KEY}"]
    assert [m["role"] for m in script.seen[0]["messages"]] == ["system", "user"]
    assert "response_format" not in script.seen[0]


def test_a_conversation_keeps_its_turns_and_settings() -> None:
    messages = (
        Message("system", "role"),
        Message("user", "first"),
        Message("assistant", "answer"),
        Message("user", "again"),
    )
    request = dataclasses.replace(
        PLAIN, messages=messages, sampling=Sampling(temperature=0.5, max_output_tokens=9, seed=3)
    )
    with serve("say") as (url, script):
        model_at(url)[0].complete(request)
    sent = script.seen[0]
    assert [(m["role"], m["content"]) for m in sent["messages"]] == [
        (m.role, m.text) for m in messages
    ]
    assert (sent["temperature"], sent["seed"]) == (0.5, 3)
    assert 9 in (sent.get("max_tokens"), sent.get("max_completion_tokens"))


def test_pictures_go_along_as_png() -> None:
    seen = dataclasses.replace(PLAIN, messages=(Message("user", "look", (b"\x89PNG",)),))
    with serve("say") as (url, script):
        model_at(url)[0].complete(seen)
    text, picture = script.seen[0]["messages"][0]["content"]
    assert text["text"] == "look"
    assert picture["image_url"]["url"].startswith("data:image/png;base64,")


def test_a_given_price_is_used() -> None:
    with serve("say") as (url, _):
        completion = connect("toy", base_url=url, price=(1.0, 10.0)).complete(PLAIN)
    assert completion.cost == pytest.approx((100 * 1.0 + 20 * 10.0) / 1e6)


@pytest.mark.parametrize(
    "fault",
    ["broken", "unavailable", "drop", "half", "no_choices", "null_choices", "page"],
)
def test_a_passing_fault_is_tried_again(fault: str) -> None:
    with serve(fault, fault, "say") as (url, script):
        model, waits = model_at(url)
        completion = model.complete(PLAIN)
    assert (completion.reply, completion.tries, len(script.seen)) == ("ready", 3, 3)
    assert len(waits) == 2 and waits[1] > waits[0] > 0


def test_retry_after_is_kept() -> None:
    with serve("busy", "say") as (url, _):
        model, waits = model_at(url)
        assert model.complete(PLAIN).reply == "ready"
    assert waits == [7.0]


def test_a_stall_is_given_up_and_tried_again() -> None:
    with serve("stall", "say") as (url, _):
        model, _ = model_at(url, seconds=0.5)
        completion = model.complete(PLAIN)
    assert (completion.reply, completion.tries) == ("ready", 2)


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        ("broken", "HTTP 500"),
        ("drop", "no connection"),
        ("half", "cannot be read"),
        ("no_choices", "without content"),
        ("page", "ends in /v1"),
        ("busy", "busy: slow down"),
        ("busy_for_an_hour", "asks to wait 3600 s"),
    ],
)
def test_a_lasting_fault_ends_in_one_line(fault: str, said: str) -> None:
    with serve(fault) as (url, script):
        model, _ = model_at(url, tries=2)
        with pytest.raises(ModelUnavailable, match=said) as caught:
            model.complete(PLAIN)
    assert "\n" not in str(caught.value) and "run the same command" in str(caught.value)
    assert len(script.seen) == (1 if fault == "busy_for_an_hour" else 2)


def test_nobody_listens() -> None:
    with serve("say") as (url, _):
        pass
    with pytest.raises(ModelUnavailable, match="no connection"):
        model_at(url, tries=2)[0].complete(PLAIN)


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        ("wrong_key", "the key was refused"),
        ("wrong_model", "no model of the name"),
        ("wrong_path", "ends in /v1"),
        ("no_money", "quota is used up"),
        ("refused", "HTTP 400: temperature is not supported"),
        ("too_long", "too long"),
    ],
)
def test_what_can_never_work_is_said_at_once_and_shows_no_key(fault: str, said: str) -> None:
    with serve(fault) as (url, script):
        model, waits = model_at(url)
        with pytest.raises(InputError, match=said) as caught:
            model.complete(PLAIN)
    assert "\n" not in str(caught.value)
    assert KEY not in str(caught.value) and caught.value.__cause__ is None
    assert (len(script.seen), waits) == (1, [])


def test_a_schema_is_sent_until_it_is_refused_once() -> None:
    with serve("no_schema") as (url, script):
        model, _ = model_at(url)
        first, second = model.complete(FORMED), model.complete(FORMED)
    assert ["response_format" in body for body in script.seen] == [True, False, False]
    assert (first.structured, second.structured) == (False, False)
    assert (first.tries, second.tries) == (2, 1)


def test_a_server_that_takes_schemas_gets_them_with_their_bounds() -> None:
    bounded = {"type": "number", "minimum": 0.25, "maximum": 3}
    schema = SCHEMA | {"properties": {"length": bounded}}
    with serve(("say", '{"length": 1}')) as (url, script):
        completion = model_at(url)[0].complete(dataclasses.replace(PLAIN, schema=schema))
    assert completion.structured
    sent = script.seen[0]["response_format"]["json_schema"]["schema"]["properties"]["length"]
    assert (sent["minimum"], sent["maximum"]) == (0.25, 3)


def test_odd_answers_are_answers() -> None:
    with serve("silent", "uncounted", "cut_off") as (url, _):
        model, _ = model_at(url)
        silent, uncounted, cut_off = (model.complete(PLAIN) for _ in range(3))
    assert silent.reply == ""
    assert uncounted.input_tokens > 0 and uncounted.output_tokens > 0
    assert cut_off.truncated and not silent.truncated


@pytest.mark.parametrize(
    ("steps", "structured"),
    [
        ([("say", "ready"), ("say", '{"length": 2}')], "schema"),
        (["say", "no_schema"], "words"),
        (["say", ("say", "I would rather talk.")], "no"),
    ],
)
def test_check_says_what_a_model_can_do(steps: list, structured: str) -> None:
    with serve(*steps) as (url, _):
        result = check(model_at(url)[0])
    assert (result.model, result.reply) == ("compatible:toy", "ready")
    assert result.structured == structured
    assert (result.tokens, result.cost) == (240, 0.0)


def test_keys_of_providers_do_not_go_to_other_servers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", "sk-the-real-one")
    monkeypatch.delenv(COMPATIBLE_KEY)
    with serve("say") as (url, script):
        model_at(url)[0].complete(PLAIN)
    assert script.keys == ["Bearer none"]


@pytest.mark.parametrize(
    ("model", "url", "said"),
    [
        ("gpt", None, "PROVIDER:NAME"),
        ("nowhere:toy", None, "Unknown model"),
        ("openai:toy", None, "OPENAI_API_KEY is not set"),
        pytest.param(
            *("anthropic:toy", None, "ANTHROPIC_API_KEY is not set"), marks=pytest.mark.exhaustive
        ),
        ("toy", "localhost:8080", "is no URL"),
        ("", "http://127.0.0.1:1/v1", "needs --model"),
    ],
)
def test_a_wrong_name_is_said_before_anything_is_sent(
    model: str, url: str | None, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("OPENAI_API_KEY", "ANTHROPIC_API_KEY"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(InputError, match=said):
        connect(model, base_url=url)


def test_without_the_library_the_remedy_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "robomore.llm.client", None)
    with pytest.raises(InputError, match=r"pip install 'robomore\[llm\]'"):
        connect("openai:toy")


def test_prices_come_from_the_price_list(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", KEY)
    monkeypatch.delenv("OPENAI_BASE_URL", raising=False)
    assert connect("openai:gpt-4o").cost(1_000_000, 0) > 0
    assert connect("openai:no-such-model").cost(1_000_000, 0) is None
    assert connect("ollama:anything").cost(1_000_000, 0) == 0
    monkeypatch.setenv("OPENAI_BASE_URL", "https://proxy.example.com/v1")
    assert connect("openai:gpt-4o").cost(1_000_000, 0) > 0
