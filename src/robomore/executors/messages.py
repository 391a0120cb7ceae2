"""The messages between an executor and its worker process: one JSON object a line, never pickle."""

from __future__ import annotations

import msgspec


class Call(msgspec.Struct, tag="call", frozen=True):
    """To the worker: run `function` (`module:name`) on `payload`."""

    function: str
    payload: bytes


class Progressed(msgspec.Struct, tag="progress", frozen=True):
    """From the worker: the running job has done so many units."""

    units: int


class Replied(msgspec.Struct, tag="reply", frozen=True):
    """From the worker: the function returned."""

    reply: bytes


class Raised(msgspec.Struct, tag="raised", frozen=True):
    """From the worker: the function raised an exception."""

    traceback: str


Reply = Progressed | Replied | Raised
