"""A number in shared memory that tells the parent which reward call is going on.

A reward that never returns holds the interpreter, and a loop inside a C function cannot even be
interrupted by a signal handler. So the sandboxed process only writes the number of the call when
it begins, and 0 when it ends. The parent looks a few times a second: if it sees the same number
again and again, the call is stuck.
"""

from __future__ import annotations

import fcntl
import mmap
import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import count
from typing import Any

SIZE = mmap.PAGESIZE

_slots: memoryview | None = None
_next_call = count(1).__next__


@contextmanager
def page() -> Iterator[int]:
    """Make the shared page and yield its file descriptor.

    On Linux the page is in memory and its size is sealed, so that neither a full disk nor the
    sandboxed process can make the parent's access to it fail.
    """
    if sys.platform == "linux":
        descriptor = os.memfd_create("heartbeat", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        os.truncate(descriptor, SIZE)
        fcntl.fcntl(
            descriptor,
            fcntl.F_ADD_SEALS,
            fcntl.F_SEAL_SEAL | fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW,
        )
    else:
        with tempfile.TemporaryFile() as file:
            file.truncate(SIZE)
            descriptor = os.dup(file.fileno())
    try:
        yield descriptor
    finally:
        os.close(descriptor)


def attach(descriptor: int) -> None:
    """Write to the shared page behind `descriptor` from now on."""
    global _slots
    _slots = memoryview(mmap.mmap(descriptor, SIZE)).cast("Q")


@contextmanager
def watched() -> Iterator[None]:
    """Count a block in which untrusted code may run as one call, though it is no reward call."""
    if _slots is None:
        yield
        return
    outer = _slots[0]
    _slots[0] = _next_call()
    try:
        yield
    finally:
        _slots[0] = outer


def watch(function: Callable[[Any, Any, Any], Any]) -> Callable[[Any, Any, Any], Any]:
    """Return `function` with every call numbered, or unchanged where no parent watches."""
    if _slots is None:
        return function
    slots, next_call = _slots, _next_call

    def counted(simulation: Any, x_velocity: Any, action: Any) -> Any:
        slots[0] = next_call()
        try:
            return function(simulation, x_velocity, action)
        finally:
            slots[0] = 0

    counted.__wrapped__ = function  # type: ignore[attr-defined]  # as functools.wraps does
    return counted
