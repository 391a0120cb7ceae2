"""Says of an error what it is and where in the reward it arose. Imports next to nothing, for it is
needed where memory has run out.
"""

from __future__ import annotations

import linecache
import traceback

from robomore.sandbox import heartbeat as pulse

FILENAME = "<reward>"
"""The name under which a reward's lines stand in tracebacks."""

_LONGEST = 2_000
"""Characters of a stranger's own words that a diagnosis repeats."""


def explain(error: BaseException) -> str:
    """Return what `error` is and in which line of the reward it arose, in one short paragraph."""
    kind = type(error).__name__
    try:
        with pulse.watched():
            said = str(error)[:_LONGEST]
    except BaseException:  # noqa: BLE001  # a stranger's exception may fail to describe itself
        said = "(its message cannot be read)"
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
