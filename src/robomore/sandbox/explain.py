"""Describes an error and the line of untrusted code in which it arose.

It imports next to nothing, because it is needed when memory has run out.
"""

from __future__ import annotations

import linecache
import traceback

from robomore.sandbox import heartbeat
from robomore.suggestions import meant

FILENAME = "<reward>"
"""The name under which a reward's lines stand in tracebacks."""

_LONGEST = 2_000
"""Most characters of an error's own message that a diagnosis repeats."""


def explain(error: BaseException) -> str:
    """Return what `error` is and in which line of the reward it arose, in one short paragraph."""
    kind = type(error).__name__
    try:
        with heartbeat.watched():
            said = str(error)[:_LONGEST]
    except BaseException:  # noqa: BLE001  # an untrusted exception may raise as it describes itself
        said = "(its message cannot be read)"
    said += meant(error)
    where = reward_line(error)
    place = f" (line {where[0]}: `{where[1]}`)" if where else ""
    return f"{kind}: {said}{place}" if said else f"{kind}{place}"


def reward_line(error: BaseException) -> tuple[int, str] | None:
    """Return number and text of the innermost line of the reward that `error` passed through."""
    frames = [
        (frame.f_code.co_filename, number)
        for frame, number in traceback.walk_tb(error.__traceback__)
    ]
    lines = [number for filename, number in frames if filename == FILENAME]
    if not lines:
        return None
    return lines[-1], linecache.getline(FILENAME, lines[-1]).strip()
