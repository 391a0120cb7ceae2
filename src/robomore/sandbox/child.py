"""The sandboxed process: it restricts itself, then calls one function that may run untrusted code.

`call.run_sandboxed` starts it in a fresh interpreter. No untrusted code is touched before all
layers are on. Whatever this process sends afterwards is only a claim.
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
from pathlib import Path
from types import ModuleType
from typing import NoReturn

import msgspec

from robomore.errors import (
    InvalidMorphology,
    InvalidReward,
    RewardFailed,
    TrainingDiverged,
    UnstableSimulation,
)
from robomore.sandbox import heartbeat
from robomore.sandbox.explain import explain, reward_line
from robomore.sandbox.restrictions import LayerMissing, Restrictions, apply_restrictions
from robomore.sandbox.wire import MAX_BODY, Kind, pack_number, send
from robomore.types import Status

_LONGEST = 20_000
"""Characters of a diagnosis."""

_RESERVE = 8 * 2**20
"""Bytes set aside, so that there is memory to describe the error when it has run out."""

_STATUS: dict[type[BaseException], Status] = {
    InvalidMorphology: Status.INVALID_MORPHOLOGY,
    InvalidReward: Status.INVALID_REWARD,
    RewardFailed: Status.REWARD_FAILED,
    UnstableSimulation: Status.UNSTABLE,
    TrainingDiverged: Status.TRAINING_DIVERGED,
    MemoryError: Status.OUT_OF_MEMORY,
}


def main(replies: int, heartbeat_page: int) -> NoReturn:
    """Serve the one request on standard input and end the process.

    Args:
        replies: descriptor of the pipe that frames go to.
        heartbeat_page: descriptor of the shared page of `heartbeat`.
    """
    with os.fdopen(0, "rb", closefd=False) as stdin:
        header = json.loads(stdin.readline())
        payload = stdin.read()
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    heartbeat.attach(heartbeat_page)
    os.close(heartbeat_page)
    # Lets the parent ask which line a stuck call is in, even while C code holds the interpreter.
    faulthandler.register(signal.SIGUSR1, all_threads=False)
    faulthandler.enable(all_threads=False)
    # Gymnasium imports it to open windows, and it would start a process to find its library.
    sys.modules["glfw"] = ModuleType("glfw")
    # Looks through the search path once, while all of it can be read.
    for module in header["modules"]:
        importlib.util.find_spec(module)
    try:
        layers = apply_restrictions(msgspec.convert(header["restrictions"], Restrictions))
    except LayerMissing as error:
        send(replies, Kind.REFUSED, str(error).encode())
        os._exit(1)
    send(replies, Kind.LAYERS, msgspec.json.encode(layers))
    try:
        _serve(header["function"], payload, Path(header["scratch"]), replies)
    finally:
        # So no exit hook, thread or finaliser of untrusted code gets to run.
        os._exit(0)


def _serve(name: str, payload: bytes, scratch: Path, replies: int) -> None:
    reserve = [bytearray(_RESERVE)]
    try:
        module, _, function = name.partition(":")
        call = getattr(importlib.import_module(module), function)
        reply = call(payload, scratch, lambda n: send(replies, Kind.PROGRESS, pack_number(n)))
        if not isinstance(reply, bytes) or len(reply) > MAX_BODY:
            raise TypeError(f"{name} returned no bytes, or more than {MAX_BODY} of them")
    except BaseException as error:  # noqa: BLE001  # untrusted code may raise SystemExit and worse
        reserve.clear()
        with heartbeat.watched():
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
            text = explain(error) if kind is MemoryError else str(error)
            return status, text[:_LONGEST]
    if reward_line(error) is not None:
        return Status.REWARD_FAILED, explain(error)[:_LONGEST]
    said = "".join(traceback.format_exception(error))[-_LONGEST:]
    if isinstance(error, PermissionError) and error.filename is not None:
        said = (
            f"a sandboxed process may not use {error.filename}: it reads installed packages alone, "
            "and of what was installed with `pip install -e` only the modules. If a task or a "
            f"trainer of your own needs the file, install its package without -e.\n{said}"
        )
    return Status.FAILED, said
