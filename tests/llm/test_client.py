"""A real client against a server that misbehaves: progress, or one clear line."""

from __future__ import annotations

import dataclasses
import gzip
import json
import re
import resource
import sys

import pytest
from loopback import KEY, Handler, raw, serve

from robomore.designers.llm.extraction import object_in
from robomore.designers.llm.thoughts import without_thoughts
from robomore.errors import InputError, ModelUnavailable
from robomore.llm import (
    BudgetedClient,
    MemoryLog,
    Message,
    ModelBudget,
    Request,
    Sampling,
    check,
    connect,
)
from robomore.llm.providers import COMPATIBLE_KEY
from robomore.llm.retry import RetryPolicy
from robomore.llm.trouble import trouble_with
from robomore.types import Slot

pytest.importorskip("pydantic_ai")

SCHEMA = {
    "title": "check",
    "type": "object",
    "properties": {"length": {"type": "number"}},
    "required": ["length"],
    "additionalProperties": False,
}
COUNTED = {"prompt_tokens": 90, "completion_tokens": 20, "total_tokens": 110}
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
    ["broken", "unavailable", "drop", "half", "no_choices", "null_choices"],
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


@pytest.mark.parametrize("fault", ["stall", "drip_body", "drip_head", "drip_continue"])
def test_a_stall_is_given_up_and_tried_again(fault: str) -> None:
    with serve(fault, "say") as (url, _):
        model, _ = model_at(url, seconds=0.5)
        completion = model.complete(PLAIN)
    assert (completion.reply, completion.tries) == ("ready", 2)


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        ("broken", "HTTP 500"),
        ("drop", "before it had answered"),
        ("half", "cannot be read"),
        ("no_choices", "without content"),
        ("choices_as_text", "sent a text as `choices`"),
        ("choices_as_numbers", "`choices` that hold a number"),
        ("message_as_list", "cannot be read: choices.0.message: "),
        ("content_as_number", "cannot be read: choices.0.message.content: .*valid string"),
        ("not_an_object", "sent a list in the place of an object"),
        ("error_as_answer", "sent an error as if it were an answer: out of memory"),
        ("broken_page", r"HTTP 500: a web page in the place of an answer \('oops'\)"),
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
    assert not re.search("pydantic|attribute|input_value|ends in /v1", str(caught.value))
    assert len(script.seen) == (1 if fault == "busy_for_an_hour" else 2)


@pytest.mark.parametrize(
    "status", ["301 Moved", "302 Found", "303 Other", "307 Temporary", "308 Permanent"]
)
def test_no_redirect_is_followed(status: str) -> None:
    """Neither to another server, which would get the key, nor to a file, nor in a circle."""
    with serve("say") as (elsewhere, other):
        for place in (elsewhere, "file:///etc/passwd", "/v1/chat/completions", "http://[::1", ""):
            with serve(raw(status, f"location: {place}")) as (url, script):
                model, waits = model_at(url)
                with pytest.raises(InputError, match=r"elsewhere \(HTTP 30") as caught:
                    model.complete(PLAIN)
            assert (len(script.seen), waits) == (1, [])
            assert place in str(caught.value) and "name it with --base-url" in str(caught.value)
        assert other.seen == []


@pytest.mark.parametrize(
    ("said", "waits"),
    [
        ("-5", False),
        ("nan", False),
        ("1e9", False),
        ("\xb2", False),
        ("9" * 400, False),
        ("Mon, 01 Jan 0001 00:00:00 GMT", False),
        ("Fri, 31 Dec 9999 23:59:59 GMT", True),
    ],
)
def test_no_retry_after_stops_a_run_in_silence(said: str, waits: bool) -> None:
    """What is no time is not waited for. A time that is far away ends the run at once."""
    with serve(raw("429 Busy", f"retry-after: {said}"), "say") as (url, _):
        model, waited = model_at(url)
        if waits:
            with pytest.raises(ModelUnavailable, match="asks to wait"):
                model.complete(PLAIN)
            assert waited == []
        else:
            assert model.complete(PLAIN).reply == "ready"
            assert len(waited) == 1 and 0 < waited[0] < 10


@pytest.mark.parametrize(
    "sent",
    [
        raw("200 OK", body=b""),
        raw("200 OK", body=b'{"choices": "\xff\xfe\xc3("}'),
        raw("200 OK", "content-length: 1000"),
        raw("200 OK", "content-length: -5"),
        raw("200 OK", "content-length: 2", "content-length: 3"),
        raw("200 OK", "transfer-encoding: chunked", body=b"zz\r\n{}"),
        raw("200 OK", "transfer-encoding: chunked", body=b"fffffffffffffff\r\n{}"),
        raw("200 OK", "x: " + "a" * 10_000_000),
        raw("200 OK", *["x: a"] * 200_000),
        raw("200 OK", "content-encoding: gzip", body=b"no gzip"),
        raw("204 No Content", body=b""),
        raw("-1 What"),
        b"SSH-2.0-OpenSSH\r\n",
        b"",
    ],
    ids=lambda sent: sent[:60].decode("latin-1").partition("\r")[0],
)
def test_what_is_no_answer_is_tried_again(sent: bytes) -> None:
    with serve(sent, "say") as (url, _):
        completion = model_at(url)[0].complete(PLAIN)
    assert (completion.reply, completion.tries) == ("ready", 2)


@pytest.mark.parametrize("after", [b" " * 9_000_000, b"\0\0\0\xff\xff" * 1_800_000])
def test_a_body_that_decompresses_to_nothing_has_an_end(after: bytes) -> None:
    """What follows the end of compressed data, and empty blocks within it."""
    whole = gzip.compress(b"{}") if after[:1] == b" " else gzip.compress(b"")[:10]
    answer = raw("200 OK", "content-encoding: gzip", body=whole + after)
    with serve(answer) as (url, _), pytest.raises(InputError, match="more than 8 MiB"):
        model_at(url)[0].complete(PLAIN)


def test_a_server_that_hangs_up_is_said_to() -> None:
    with serve(b"") as (url, _):
        model, _ = model_at(url)
        with pytest.raises(
            ModelUnavailable, match=r"closed the connection before it had answered"
        ) as told:
            model.complete(PLAIN)
    assert "Connection error" not in str(told.value)


def test_nobody_listens() -> None:
    with serve("say") as (url, _):
        pass
    model, waits = model_at(url, tries=2)
    with pytest.raises(ModelUnavailable, match="no server answers at http://127") as caught:
        model.complete(PLAIN)
    assert waits == [] and "OLLAMA_BASE_URL" in str(caught.value)


def test_a_server_that_restarts_is_waited_for() -> None:
    with serve("goodbye") as (url, _):
        model, waits = model_at(url)
        model.complete(PLAIN)
    with pytest.raises(ModelUnavailable, match="no connection"):
        model.complete(PLAIN)
    assert len(waits) == 2


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        ("wrong_key", "the key was refused"),
        ("wrong_model", "no model of the name"),
        ("wrong_path", r"says HTTP 404 with a web page \('nothing here'\); correct --base-url"),
        ("page", r"sent a web page \('please log in'\).*--base-url"),
        ("alternatives", "values"),
        ("nested", "values"),
        ("no_money", "quota is used up"),
        ("refused", "HTTP 400: temperature is not supported"),
        ("too_long", "too long"),
        ("endless", "more than 8 MiB"),
        ("gzip_bomb", "more than 8 MiB"),
        ("deflate_bomb", "more than 8 MiB"),
        ("bomb_of_an_error", "more than 8 MiB"),
        ("unknown_encoding", "in the encoding 'br'"),
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


@pytest.mark.parametrize("compression", ["gzip", "deflate"])
def test_a_compressed_answer_is_read(compression: str) -> None:
    with serve(compression) as (url, _):
        assert model_at(url)[0].complete(PLAIN).reply == "ready"


def test_an_answer_of_any_length_that_is_too_large_takes_little_memory() -> None:
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with serve("endless") as (url, _), pytest.raises(InputError):
        model_at(url)[0].complete(PLAIN)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 200 * 1024


def test_a_key_in_an_answer_is_removed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OTHER_TOKEN", "p/w+12345")
    said = f"your key {KEY}, p/w+12345 and p%2Fw%2B12345, at https://me:pass@host/v1"
    with serve(("say", said)) as (url, _):
        reply = model_at(url)[0].complete(PLAIN).reply
    assert reply == "your key ***, *** and ***, at https://***@host/v1"


@pytest.mark.parametrize("fault", ["wrong_path", "page", "broken", "drop", "wrong_model"])
def test_a_password_in_the_url_is_not_shown(fault: str) -> None:
    with serve(fault) as (url, _):
        model, _ = model_at(url.replace("://", "://user:hunter22@"), tries=1)
        with pytest.raises((InputError, ModelUnavailable)) as caught:
            model.complete(PLAIN)
    assert "hunter22" not in str(caught.value)


@pytest.mark.parametrize("url", ["ftp://user:hunter22@host/v1", "http://user:hunter22@/v1"])
def test_a_password_in_a_wrong_url_is_not_shown(url: str) -> None:
    with pytest.raises(InputError, match="is no URL") as caught:
        connect("toy", base_url=url)
    assert "hunter22" not in str(caught.value)


@pytest.mark.parametrize(
    ("step", "reply", "ending", "to_user"),
    [
        ("filtered", "", "filter", "content filter withheld"),
        ("filtered_midway", '{"len', "filter", "content filter cut"),
        ("refusing", "I cannot help with that.", "refusal", "refused to answer"),
        ("thinking_only", '{"length": 2}', "thoughts", "reasoning_content"),
        ("thinking_cut_off", "", "", "--max-output-tokens"),
        ("cut_off", '{"length": ', "", "--max-output-tokens"),
        ("silent", "", "", "gave no reason"),
        ("thinking_and_answer", "ready", "", ""),
        ("tool_call", '{"length":2}', "", ""),
    ],
)
def test_the_reason_of_an_incomplete_answer_is_kept(
    step: str, reply: str, ending: str, to_user: str
) -> None:
    with serve(step) as (url, _):
        completion = model_at(url)[0].complete(PLAIN)
    assert (completion.reply, completion.ending) == (reply, ending)
    trouble = trouble_with(completion)
    if not to_user:
        assert trouble is None
    else:
        assert trouble is not None and to_user in trouble.to_user
        assert "--" not in trouble.to_model


@pytest.mark.parametrize("fault", ["page", "wrong_path"])
def test_the_usual_end_of_a_url_is_advised_where_it_is_absent(fault: str) -> None:
    for end, advised in (("/v1", False), ("", True), ("/api", True)):
        with serve(fault) as (url, _), pytest.raises(InputError) as told:
            model_at(url.removesuffix("/v1") + end)[0].complete(PLAIN)
        assert ("usually ends in /v1" in str(told.value)) == advised


@pytest.mark.parametrize("step", ["filtered", "refusing", "thinking_cut_off", "silent"])
def test_check_fails_without_an_answer(step: str) -> None:
    with serve(step) as (url, _), pytest.raises(ModelUnavailable, match="gave no answer: the"):
        check(model_at(url)[0])


@pytest.mark.parametrize(("read", "cut"), [(4096, True), (2048, True), (8200, False), (90, False)])
def test_a_cut_prompt_is_noticed(read: int, cut: bool, caplog: pytest.LogCaptureFixture) -> None:
    def counts(body: dict) -> dict:
        return {"prompt_tokens": read, "completion_tokens": 1, "total_tokens": read + 1}

    words = Message("user", "one word after the other " * 1000)
    with serve(("counted", counts)) as (url, _):
        client = BudgetedClient(model_at(url)[0], MemoryLog())
        for repair in range(2):
            client.ask(dataclasses.replace(PLAIN, repair=repair, messages=(words,)))
        found = check(model_at(url)[0]).prompt_cut
    warned = [r.message for r in caplog.records if "cuts prompts" in r.message]
    assert len(warned) == cut and bool(found) == cut
    assert not cut or ("OLLAMA_CONTEXT_LENGTH" in found and f"{read:,} tokens" in found)


@pytest.mark.filterwarnings("error:Failed to extract usage")
@pytest.mark.parametrize(
    "usage",
    [
        {"prompt_tokens": "many", "completion_tokens": [], "total_tokens": None},
        {"prompt_tokens": -5, "completion_tokens": -(10**30), "total_tokens": 0},
        {"prompt_tokens": 10**300, "completion_tokens": 10**18, "total_tokens": 3},
        {"prompt_tokens": {"a": {"b": [1]}}, "completion_tokens": 5, "total_tokens": 5},
        {"prompt_tokens": 5.5, "completion_tokens": 1e300, "total_tokens": 5},
        {"prompt_tokens": True, "completion_tokens": False, "total_tokens": 1},
        {"total_tokens": 5},
        {**COUNTED, "prompt_tokens_details": {"cached_tokens": -9}},
        {**COUNTED, "completion_tokens_details": {"reasoning_tokens": 10**40}},
        {**COUNTED, "prompt_tokens_details": "x"},
        {},
        [1],
        5,
        "many",
    ],
    ids=str,
)
def test_an_odd_usage_is_estimated_in_silence(usage: object) -> None:
    answer = json.dumps(Handler.answer("ready") | {"usage": usage}).encode()
    with serve(raw("200 OK", body=answer)) as (url, _):
        completion = model_at(url)[0].complete(PLAIN)
    assert (completion.reply, completion.tries) == ("ready", 1)
    assert 0 < completion.input_tokens < 100 and 0 < completion.output_tokens < 10


def test_a_usage_with_more_than_counts_is_read() -> None:
    usage = COUNTED | {"prompt_tokens_details": {"cached_tokens": 3}, "tier": "standard"}
    answer = json.dumps(Handler.answer("ready") | {"usage": usage}).encode()
    with serve(raw("200 OK", body=answer)) as (url, _):
        completion = model_at(url)[0].complete(PLAIN)
    assert (completion.input_tokens, completion.output_tokens) == (90, 20)


@pytest.mark.parametrize("field", ["prompt_tokens", "completion_tokens"])
@pytest.mark.parametrize("count", [10**30, 2**63, -(10**6)])
def test_a_count_that_cannot_be_true_does_not_use_up_the_budget(field: str, count: int) -> None:
    def counts(body: dict) -> dict:
        return {"prompt_tokens": 9, "completion_tokens": 9, "total_tokens": 18} | {field: count}

    with serve(("counted", counts)) as (url, _):
        client = BudgetedClient(model_at(url)[0], log := MemoryLog(), ModelBudget(tokens=10_000))
        for repair in range(2):
            client.ask(dataclasses.replace(PLAIN, repair=repair))
    assert 0 < log.spent().tokens < 1000


def test_odd_answers_are_answers() -> None:
    with serve("silent", "uncounted", "cut_off") as (url, _):
        model, _ = model_at(url)
        silent, uncounted, cut_off = (model.complete(PLAIN) for _ in range(3))
    assert silent.reply == ""
    assert uncounted.input_tokens > 0 and uncounted.output_tokens > 0
    assert cut_off.truncated and not silent.truncated


@pytest.mark.parametrize(
    ("steps", "said"),
    [
        (["say", ("say", '{"size": 2}')], "'{\"size\": 2}', which is JSON of another form"),
        (["say", ("say", "a length of 2")], "'a length of 2', which is no JSON"),
        ([("say", "I'm sorry, I can't.")], "it refuses, or cannot follow: choose another model"),
    ],
)
def test_check_says_what_came_in_the_place_of_what_was_asked_for(steps: list, said: str) -> None:
    with serve(*steps) as (url, _):
        result = check(model_at(url)[0])
    assert len(result.faults) == 1 and said in result.faults[0]


def test_check_accepts_what_a_run_reads_from_thoughts() -> None:
    with serve("thinking_only") as (url, _):
        result = check(model_at(url)[0])
    assert (result.structured, result.faults) == ("schema", ())
    assert "thoughts" in result.note


@pytest.mark.parametrize(
    ("steps", "structured"),
    [
        ([("say", "ready"), ("say", '{"length": 2}')], "schema"),
        (["say", "no_schema"], "words"),
        (["say", ("say", '<think>{3}?</think>```json\n{"length": 2}\n```')], "wrapped"),
        (["say", ("say", '[THINK]{"length": 3}?[/THINK]{"length": 2}')], "wrapped"),
        (["say", ("say", "{“length“: 2.5}")], "wrapped"),
        (["say", ("say", '\ufeff{"length": 2, // m\n}')], "wrapped"),
        ([("say", "[THINK]Hm.[/THINK]ready"), ("say", '{"length": 2}')], "schema"),
        (["say", ("say", "I would rather talk.")], "no"),
    ],
)
def test_check_says_what_a_model_can_do(steps: list, structured: str) -> None:
    with serve(*steps) as (url, _):
        result = check(model_at(url)[0], None, object_in, without_thoughts)
    assert (result.model, result.reply) == ("toy", "ready")
    assert result.structured == structured
    assert bool(result.faults) == (structured == "no")
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
        ("nowhere:toy", None, "no provider is called 'nowhere'"),
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
