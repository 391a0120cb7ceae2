"""Functions for workers to run: one that works and some that do what they should not."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable


def double(payload: bytes, progress: Callable[[int], None]) -> bytes:
    progress(1)
    return payload * 2


def environment(payload: bytes, progress: Callable[[int], None]) -> bytes:
    return repr(sorted(os.environ)).encode()


def misbehave(payload: bytes, progress: Callable[[int], None]) -> bytes:
    match payload:
        case b"raise":
            raise ValueError("on purpose")
        case b"exit":
            os._exit(3)
        case b"kill":
            os.kill(os.getpid(), signal.SIGKILL)
        case b"hang":
            time.sleep(60)
        case b"print":
            os.write(1, b"more noise\n")
    return payload
