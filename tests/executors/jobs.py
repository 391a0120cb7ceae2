"""Functions for workers to run, some of which do what they should not."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable
from pathlib import Path

import msgspec

from robomore.errors import UnfitWorker
from robomore.evaluation.request import Request
from robomore.executors.carried import carried_folder
from untrained import answer


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


def once(payload: bytes, progress: Callable[[int], None]) -> bytes:
    """Do what the payload's first word says the first time, and return the second time.

    The second word names a file that tells the times apart.
    """
    what, _, name = payload.decode().partition(" ")
    if Path(name).exists():
        return b"done"
    Path(name).touch()
    if what == "slow":
        time.sleep(300)
    if what == "unfit":
        raise UnfitWorker("it is the first machine")
    os.kill(os.getppid(), signal.SIGKILL)  # Ray's own process on this machine
    time.sleep(60)
    return b"outlived its parent"


def unfit(payload: bytes, progress: Callable[[int], None]) -> bytes:
    raise UnfitWorker("no machine is good enough")


def everything_around(payload: bytes, progress: Callable[[int], None]) -> bytes:
    """Return the environment of this process and of all from which it comes, up to a given one."""
    found, process = b"", os.getpid()
    while process > 1 and process != int(payload):
        found += Path(f"/proc/{process}/environ").read_bytes() + b"\n"
        process = int(Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[1])
    return found


def count(payload: bytes, progress: Callable[[int], None]) -> bytes:
    """Add a line to a file in the carried folder of that name; return the lines."""
    folder = carried_folder(payload.decode())
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "lines").open("a") as file:
        file.write("x")
    return (folder / "lines").read_bytes()


def made_up_work(payload: bytes, progress: Callable[[int], None]) -> bytes:
    """Stand in for `robomore.evaluation.work:work`: the same numbers, and no training."""
    request = msgspec.json.decode(payload, type=Request)
    time.sleep(1.0)
    progress(request.job.steps)
    return answer(request)
