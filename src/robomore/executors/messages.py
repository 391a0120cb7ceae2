"""What parent and worker say to each other: one JSON object a line, never pickle."""

from __future__ import annotations

import msgspec


class Call(msgspec.Struct, tag="call", frozen=True):
    """Run `function` (`module:name`) on `payload`."""

    function: str
    payload: bytes


class Progressed(msgspec.Struct, tag="progress", frozen=True):
    """The running job has done so many units."""

    units: int


class Replied(msgspec.Struct, tag="reply", frozen=True):
    """The function returned."""

    reply: bytes


class Raised(msgspec.Struct, tag="raised", frozen=True):
    """The function raised, which it should not."""

    traceback: str


Reply = Progressed | Replied | Raised
