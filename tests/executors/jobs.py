"""Functions for workers to run, some of which do what they should not."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable


def environment(payload: bytes, progress: Callable[[int], None]) -> bytes:
    return repr(sorted(os.environ)).encode()


def misbehave(payload: bytes, progress: Callable[[int], None]) -> bytes:
    match payload:
        case b"exit":
            os._exit(3)
        case b"kill":
            os.kill(os.getpid(), signal.SIGKILL)
        case b"hang":
            time.sleep(60)
        case b"print":
            os.write(1, b"more noise\n")
    return payload
