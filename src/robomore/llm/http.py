"""The HTTP client for providers. It reads no more of an answer than an answer can need."""

from __future__ import annotations

import zlib
from collections.abc import AsyncIterator

import httpx2

LARGEST_ANSWER = 8 * 2**20
"""Bytes of an answer after decompression. The longest answers of models have a tenth of it."""
_CONNECT_SECONDS = 5.0


class AnswerTooLarge(Exception):
    """A server sent more than `LARGEST_ANSWER` bytes, or in an encoding that nobody asked for."""


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
    response.stream = _Bounded(response.stream, encoding not in ("", "identity"))


class _Bounded(httpx2.AsyncByteStream):
    """A body that is decompressed in pieces, and that ends in an error if it is too large."""

    def __init__(self, stream: httpx2.AsyncByteStream, compressed: bool) -> None:
        self._stream = stream
        # 32 is added so that zlib finds out whether the data is gzip or deflate.
        self._decompressor = zlib.decompressobj(zlib.MAX_WBITS + 32) if compressed else None
        self._left = LARGEST_ANSWER

    async def __aiter__(self) -> AsyncIterator[bytes]:
        async for raw in self._stream:
            part = raw
            if self._decompressor is not None:
                # Of what does not fit, one byte is enough to notice it.
                part = self._decompressor.decompress(raw, self._left + 1)
            self._left -= len(part)
            if self._left < 0:
                raise AnswerTooLarge(f"an answer of more than {LARGEST_ANSWER // 2**20} MiB")
            yield part

    async def aclose(self) -> None:
        await self._stream.aclose()
