"""The messages from a sandboxed process to its parent: small frames on a pipe, of bounded length.

Once untrusted code runs, it can write anything to this pipe. So the parent trusts no more of a
frame than that its kind is known and that its length is allowed.
"""

from __future__ import annotations

import os
import struct
from enum import IntEnum

MAX_BODY = 16 * 2**20
"""Longest body of one frame, in bytes."""


class Kind(IntEnum):
    """What a frame carries."""

    LAYERS = 1
    """The layers are on; JSON list of them. Sent before any untrusted code runs."""
    REFUSED = 2
    """A required layer is missing and the process stopped; the reason as text."""
    PROGRESS = 3
    """Units of work done, as one signed 64-bit integer."""
    REPLY = 4
    """What the function returned."""
    FAULT = 5
    """JSON list of status and diagnosis: how the function ended instead."""


class MalformedFrame(ValueError):
    """Bytes that no process sends unless untrusted code wrote them."""


MOST_BYTES = 2 * MAX_BODY
"""All frames of one process together. Millions of reports of progress fit, a flood does not."""

_HEAD = struct.Struct("<BI")
_NUMBER = struct.Struct("<q")


def send(descriptor: int, kind: Kind, body: bytes) -> None:
    """Write one frame, whole."""
    rest = memoryview(_HEAD.pack(kind, len(body)) + body)
    while rest:
        rest = rest[os.write(descriptor, rest) :]


def pack_number(value: int) -> bytes:
    return _NUMBER.pack(value)


def unpack_number(body: bytes) -> int:
    """Raises `MalformedFrame` where `body` is not one 64-bit integer."""
    if len(body) != _NUMBER.size:
        raise MalformedFrame(f"a progress frame of {len(body)} bytes")
    return int(_NUMBER.unpack(body)[0])


class Frames:
    """Cuts what arrives on the pipe into frames, holding at most one of them unfinished."""

    def __init__(self) -> None:
        self._held = bytearray()
        self._arrived = 0

    def feed(self, arrived: bytes) -> list[tuple[Kind, bytes]]:
        """Return the frames that `arrived` completes.

        Raises:
            MalformedFrame: an unknown kind, a body longer than `MAX_BODY`, or more than
                `MOST_BYTES` in all.
        """
        self._arrived += len(arrived)
        if self._arrived > MOST_BYTES:
            raise MalformedFrame(f"more than {MOST_BYTES >> 20} MiB")
        self._held += arrived
        frames, begin = [], 0
        while len(self._held) >= begin + _HEAD.size:
            number, length = _HEAD.unpack_from(self._held, begin)
            if number not in _KINDS or length > MAX_BODY:
                raise MalformedFrame(f"a frame of kind {number} and {length} bytes")
            end = begin + _HEAD.size + length
            if len(self._held) < end:
                break
            frames.append((Kind(number), bytes(self._held[begin + _HEAD.size : end])))
            begin = end
        del self._held[:begin]
        return frames


_KINDS = frozenset(Kind)
