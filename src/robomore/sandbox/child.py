"""The contained child: locks itself in, then calls one function that may run a stranger's code.

Started by `contain.run_contained` in a fresh interpreter. Nothing of the stranger's is touched
before all layers are on, and nothing that this process says afterwards is more than a claim.
"""

from __future__ import annotations

import faulthandler
import importlib
import importlib.util
import json
import os
import signal
import sys
import traceback
from dataclasses import astuple
from pathlib import Path
from types import ModuleType
from typing import NoReturn

from robomore.errors import (
    InvalidMorphology,
    InvalidReward,
    RewardFailed,
    TrainingDiverged,
    UnstableSimulation,
)
from robomore.rewards.explain import explain, reward_line
from robomore.sandbox import heartbeat as pulse
from robomore.sandbox.lock import CannotLock, Lock, lock
from robomore.sandbox.wire import MAX_BODY, Kind, pack_number, send
from robomore.types import Status

_LONGEST = 20_000
"""Characters of a diagnosis."""

_RESERVE = 8 * 2**20
"""Bytes to say in what has happened when memory has run out."""

_STATUS: dict[type[BaseException], Status] = {
    InvalidMorphology: Status.INVALID_MORPHOLOGY,
    InvalidReward: Status.INVALID_REWARD,
    RewardFailed: Status.REWARD_FAILED,
    UnstableSimulation: Status.UNSTABLE,
    TrainingDiverged: Status.TRAINING_DIVERGED,
    MemoryError: Status.OUT_OF_MEMORY,
}


def main(replies: int, pulses: int) -> NoReturn:
    """Serve the one request on standard input and end the process.

    Args:
        replies: descriptor of the pipe that frames go to.
        pulses: descriptor of the page that `pulse` counts in.
    """
    with os.fdopen(0, "rb", closefd=False) as stdin:
        header = json.loads(stdin.readline())
        payload = stdin.read()
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    pulse.attach(pulses)
    os.close(pulses)
    # Lets the parent ask which line a stuck call is in, even while C code holds the interpreter.
    faulthandler.register(signal.SIGUSR1, all_threads=False)
    faulthandler.enable(all_threads=False)
    # Gymnasium imports it to open windows, and it would start a process to find its library.
    sys.modules["glfw"] = ModuleType("glfw")
    # Looks through the search path once, while all of it can be read.
    importlib.util.find_spec(header["function"].partition(":")[0].partition(".")[0])
    try:
        layers = lock(Lock.from_json(header["lock"]))
    except CannotLock as error:
        send(replies, Kind.REFUSED, str(error).encode())
        os._exit(1)
    send(replies, Kind.LOCKED, json.dumps([astuple(layer) for layer in layers]).encode())
    try:
        _serve(header["function"], payload, Path(header["scratch"]), replies)
    finally:
        # No atexit hook, thread or finaliser that a stranger left gets to run.
        os._exit(0)


def _serve(name: str, payload: bytes, scratch: Path, replies: int) -> None:
    reserve = [bytearray(_RESERVE)]
    try:
        module, _, function = name.partition(":")
        call = getattr(importlib.import_module(module), function)
        reply = call(payload, scratch, lambda n: send(replies, Kind.PROGRESS, pack_number(n)))
        if not isinstance(reply, bytes) or len(reply) > MAX_BODY:
            raise TypeError(f"{name} returned no bytes, or more than {MAX_BODY} of them")
    except BaseException as error:  # noqa: BLE001  # a stranger may raise SystemExit and worse
        reserve.clear()
        with pulse.watched():
            fault = _fault(error)
        send(replies, Kind.FAULT, json.dumps(fault).encode())
    else:
        send(replies, Kind.REPLY, reply)


def _fault(error: BaseException) -> tuple[str, str]:
    """Return status and diagnosis of what `error` means for the evaluation."""
    if isinstance(error.__cause__, MemoryError):
        return Status.OUT_OF_MEMORY, str(error)[:_LONGEST]
    for kind, status in _STATUS.items():
        if isinstance(error, kind):
            said = explain(error) if kind is MemoryError else str(error)
            return status, said[:_LONGEST]
    if reward_line(error) is not None:
        return Status.REWARD_FAILED, explain(error)[:_LONGEST]
    return Status.FAILED, "".join(traceback.format_exception(error))[-_LONGEST:]
