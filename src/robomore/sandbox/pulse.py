"""A counter in shared memory that tells the parent whether a reward call is going on.

A reward that never returns holds the interpreter, and a loop inside a C function cannot even be
interrupted by a signal handler. So the child only counts, up by one as a call begins and again as
it ends, and the parent looks at the number some times a second: odd and unchanged means stuck.
"""

from __future__ import annotations

import mmap
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

SIZE = mmap.PAGESIZE

_slots: memoryview | None = None


def attach(descriptor: int) -> None:
    """Count in the shared page behind `descriptor` from now on."""
    global _slots
    _slots = memoryview(mmap.mmap(descriptor, SIZE)).cast("Q")


@contextmanager
def watched() -> Iterator[None]:
    """Mark a stretch in which a stranger's code may run, other than a reward call."""
    if _slots is not None:
        _slots[0] += 1
    try:
        yield
    finally:
        if _slots is not None:
            _slots[0] += 1


def watch(function: Callable[[Any, Any, Any], Any]) -> Callable[[Any, Any, Any], Any]:
    """Return `function` with every call counted; as it is where no parent watches."""
    if _slots is None:
        return function
    slots = _slots

    def counted(simulation: Any, x_velocity: Any, action: Any) -> Any:
        slots[0] += 1
        try:
            return function(simulation, x_velocity, action)
        finally:
            slots[0] += 1

    return counted
