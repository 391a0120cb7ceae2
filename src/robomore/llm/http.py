"""The HTTP client for providers. It reads no more of an answer than an answer can need."""

from __future__ import annotations

import re
import zlib
from collections.abc import AsyncIterator

import httpx2

LARGEST_ANSWER = 8 * 2**20
"""Bytes of an answer after decompression. The longest answers of models have a tenth of it."""
_CONNECT_SECONDS = 5.0


MOST_VALUES = 5_000
"""Values in the JSON of an answer. Those of models have some dozens; a provider's library needs
0.3 ms for each alternative answer."""

# What is not closed reaches to the end, so that no text is read again and again.
_TEXT = re.compile(rb'"(?:[^"\\]++|\\.)*+"?', re.DOTALL)
_MARKUP = re.compile(r"<(script|style)\b.*?(?:</\1\s*>|\Z)|<[^>]*+>?", re.DOTALL | re.IGNORECASE)


class AnswerTooLarge(Exception):
    """A server sent more bytes or values than an answer has, or an encoding nobody asked for."""


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
        self._left = LARGEST_ANSWER

    async def __aiter__(self) -> AsyncIterator[bytes]:
        parts: list[bytes] = []
        async for raw in self._stream:
            part = raw
            if self._decompressor is not None:
                # Of what does not fit, one byte is enough to notice it.
                part = self._decompressor.decompress(raw, self._left + 1)
            self._left -= len(part)
            if self._left < 0:
                raise AnswerTooLarge(f"an answer of more than {LARGEST_ANSWER // 2**20} MiB")
            parts.append(part)
        body = b"".join(parts)
        if self._success:
            _check(body)
        yield body

    async def aclose(self) -> None:
        await self._stream.aclose()


def _check(body: bytes) -> None:
    """Refuse a body before a library reads it.

    Raises:
        WebPage: it is one.
        AnswerTooLarge: it has too many values.
    """
    if body.lstrip()[:1] == b"<":
        text = _MARKUP.sub(" ", body[:20_000].decode("utf-8", "replace"))
        raise WebPage(" ".join(text.split())[:80])
    bare = _TEXT.sub(b"", body)
    if (values := bare.count(b",") + bare.count(b"{") + bare.count(b"[")) > MOST_VALUES:
        raise AnswerTooLarge(f"an answer of {values:,} values (the most is {MOST_VALUES:,})")
