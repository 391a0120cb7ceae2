"""The HTTP client for providers. It reads no more of an answer than an answer can need."""

from __future__ import annotations

import json
import re
import zlib
from collections.abc import AsyncIterator
from typing import Any

import httpx2

LARGEST_ANSWER = 8 * 2**20
"""Bytes of an answer after decompression. The longest answers of models have a tenth of it."""
_CONNECT_SECONDS = 5.0


MOST_VALUES = 5_000
"""Values in the JSON of an answer. Those of models have some dozens; a provider's library needs
0.3 ms for each alternative answer."""

MOST_TOKENS = 10**8
"""Tokens of a prompt or of an answer. A server that reports more is wrong, and its number would
use up every budget at once."""

_COUNTS = (
    {"prompt_tokens", "completion_tokens", "total_tokens"},
    {"input_tokens", "output_tokens"},
)
"""What the usage in an answer counts at least, by protocol."""

# What is not closed reaches to the end, so that no text is read again and again.
_TEXT = re.compile(rb'"(?:[^"\\]++|\\.)*+"?', re.DOTALL)
_MARKUP = re.compile(r"<(script|style)\b.*?(?:</\1\s*>|\Z)|<[^>]*+>?", re.DOTALL | re.IGNORECASE)


class AnswerTooLarge(Exception):
    """A server sent more bytes or values than an answer has, or an encoding nobody asked for."""


class Redirected(Exception):
    """A server wants the request, and the key in it, to go elsewhere; it says where."""


class OddAnswer(Exception):
    """A server sent JSON that is no answer; it says what it is."""


class WebPage(Exception):
    """A server sent a web page in the place of an answer; it says with which words that begins."""


def make_client(timeout: float) -> httpx2.AsyncClient:
    """Return a client for requests that take up to `timeout` seconds."""
    return httpx2.AsyncClient(
        timeout=httpx2.Timeout(timeout, connect=_CONNECT_SECONDS),
        headers={"Accept-Encoding": "gzip, deflate"},
        event_hooks={"response": [_bound]},
    )


async def _bound(response: httpx2.Response) -> None:
    """Let the body be decompressed and counted piece by piece, before anybody reads it."""
    if 300 <= response.status_code < 400:
        where = response.headers.get("location", "nowhere")
        raise Redirected(f"HTTP {response.status_code} to {where[:200]}")
    encoding = response.headers.pop("content-encoding", "identity").strip().lower()
    if encoding not in ("", "identity", "gzip", "x-gzip", "deflate"):
        raise AnswerTooLarge(f"an answer in the encoding {encoding[:20]!r}")
    assert isinstance(response.stream, httpx2.AsyncByteStream)
    response.stream = _Bounded(
        response.stream, encoding not in ("", "identity"), response.is_success
    )


class _Bounded(httpx2.AsyncByteStream):
    """A body that is decompressed in pieces, and that ends in an error if it is no small JSON."""

    def __init__(self, stream: httpx2.AsyncByteStream, compressed: bool, success: bool) -> None:
        self._stream = stream
        self._success = success
        # 32 is added so that zlib finds out whether the data is gzip or deflate.
        self._decompressor = zlib.decompressobj(zlib.MAX_WBITS + 32) if compressed else None
        # Both are counted: much can be made of little, and nothing of much.
        self._left = self._left_raw = LARGEST_ANSWER

    async def __aiter__(self) -> AsyncIterator[bytes]:
        body = bytearray()  # a list of pieces would take 40 bytes for each piece of one byte
        async for raw in self._stream:
            part = raw
            self._left_raw -= len(raw)
            if self._decompressor is not None:
                # Of what does not fit, one byte is enough to notice it.
                part = self._decompressor.decompress(raw, self._left + 1)
            self._left -= len(part)
            if min(self._left, self._left_raw) < 0:
                raise AnswerTooLarge(f"an answer of more than {LARGEST_ANSWER // 2**20} MiB")
            body += part
        if self._success:
            _check(bytes(body))
            yield _answer(bytes(body))
        else:
            yield bytes(body)

    async def aclose(self) -> None:
        await self._stream.aclose()


def _check(body: bytes) -> None:
    """Refuse a body before a library reads it.

    Raises:
        WebPage: it is one.
        AnswerTooLarge: it has too many values.
    """
    if body.lstrip()[:1] == b"<":
        raise WebPage(words_of_page(body.decode("utf-8", "replace")))
    bare = _TEXT.sub(b"", body)
    if (values := bare.count(b",") + bare.count(b"{") + bare.count(b"[")) > MOST_VALUES:
        raise AnswerTooLarge(f"an answer of {values:,} values (the most is {MOST_VALUES:,})")


def words_of_page(page: str) -> str:
    """Return the words with which a web page begins, without its markup."""
    return " ".join(_MARKUP.sub(" ", page[:20_000]).split())[:80]


def _answer(body: bytes) -> bytes:
    """Return an answer without counts of tokens that cannot be true, which are estimated then.

    Raises:
        OddAnswer: it is JSON, and no answer of any protocol.
    """
    try:
        answer = json.loads(body)
    except (ValueError, RecursionError):
        return body  # The library says what is wrong with it.
    if not isinstance(answer, dict):
        raise OddAnswer(f"{_named(answer)} in the place of an object")
    choices = answer.get("choices")
    if not choices and (answer.get("error") or answer.get("object") == "error"):
        raise OddAnswer(f"an error as if it were an answer: {_said(answer)}")
    if choices is not None and not isinstance(choices, list):
        raise OddAnswer(f"{_named(choices)} as `choices`, which is a list of answers")
    if choices and not all(isinstance(choice, dict) for choice in choices):
        raise OddAnswer(f"`choices` that hold {_named(choices[0])} in the place of an answer")
    usage = answer.get("usage")
    if usage is None or _counts(usage):
        return body
    del answer["usage"]
    return json.dumps(answer).encode()


def _named(value: Any) -> str:
    """Return what a value of JSON is, for a message."""
    kinds = {str: "a text", list: "a list", dict: "an object", bool: "a truth value"}
    return "nothing" if value is None else kinds.get(type(value), "a number")


def _said(answer: dict[str, Any]) -> str:
    """Return the message in an answer that is an error."""
    error = answer.get("error") or answer
    message = error.get("message") or error.get("detail") if isinstance(error, dict) else error
    return str(message or "it says no more")[:200]


def _counts(usage: Any) -> bool:
    """Return whether a usage holds the counts of a protocol, and no count that cannot be true."""
    if not isinstance(usage, dict) or not any(
        all(_is_count(usage.get(name)) for name in names) for names in _COUNTS
    ):
        return False
    details = [part for name, part in usage.items() if name.endswith("_details")]
    tables = [usage, *(part for part in details if isinstance(part, dict))]
    given = [one for table in tables for name, one in table.items() if name.endswith("_tokens")]
    return all(part is None or isinstance(part, dict) for part in details) and all(
        one is None or _is_count(one) for one in given
    )


def _is_count(value: Any) -> bool:
    return type(value) in (int, float) and 0 <= value <= MOST_TOKENS and value == int(value)
