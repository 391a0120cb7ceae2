"""Checks which sandbox layers this machine offers, by trying to get past each of them."""

from __future__ import annotations

import json
import os
import socket
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from robomore.sandbox.call import Containment, refused, run_sandboxed
from robomore.sandbox.restrictions import REQUIRED, Layer, describe, missing
from robomore.types import Limits, Status

_TRIES = 2
"""Attempts: a process that was killed from outside says nothing about the layers."""

_all_hold: list[Layer] = []
"""The layers, once all were found to hold. To try takes a third of a second, a study has hundreds
of runs in one process, and what a machine offers to a process does not cease while that runs."""


def layers() -> list[Layer]:
    """Return each layer, and whether it holds when a sandboxed process tries to escape."""
    with tempfile.TemporaryDirectory() as folder, _listener() as port:
        secret = Path(folder) / "secret"
        secret.write_text("secret")
        targets = {"secret": str(secret), "port": port, "parent": os.getpid()}
        for _ in range(_TRIES):
            result = run_sandboxed(
                "robomore.sandbox.layers:attempt",
                json.dumps(targets).encode(),
                Path(folder) / "scratch",
                Limits(wall_seconds=120.0),
                mode=Containment.RELAXED,
            )
            if result.status is Status.OK:
                break
    if result.status is not Status.OK:
        detail = f"the attempt to check it failed: {result.diagnosis}"
        return [Layer(name, False, detail) for name in REQUIRED]
    escapes: dict[str, list[str]] = json.loads(result.reply)
    environment = Layer("environment", True, "only the variables of an allow-list are passed on")
    watchdog = Layer(
        "watchdog", True, "limits wall-clock time, each reward call, memory and output"
    )
    return [
        replace(layer, active=False, detail=f"{layer.detail}, yet it could {', '.join(escaped)}")
        if (escaped := escapes.get(layer.name))
        else layer
        for layer in (*result.layers, environment, watchdog)
    ]


def ensure(mode: Containment) -> list[Layer]:
    """Return the layers, or refuse before a run starts what would be refused later.

    Raises:
        InputError: `mode` is strict and a required layer is missing.
    """
    found = _all_hold.copy() or layers()
    lacking = missing(found)
    if not lacking:
        _all_hold[:] = found
    if lacking and mode is Containment.STRICT:
        raise refused(describe(lacking))
    return found


def attempt(payload: bytes, scratch: Path, report: Callable[[int], None]) -> bytes:
    """Try to escape from the process that this runs in; return what worked, by layer, as JSON."""
    targets = json.loads(payload)
    secret = Path(targets["secret"])
    attempts: dict[str, dict[str, Callable[[], object]]] = {
        "files": {
            "read a file outside its folder": secret.read_text,
            "list a folder outside its own": lambda: list(secret.parent.iterdir()),
            "write outside its folder": lambda: secret.with_name("left").write_text("x"),
            "remove a file outside its folder": secret.unlink,
        },
        "system calls": {
            "open a connection": lambda: _connect(targets["port"]),
            "make a Unix socket": lambda: socket.socket(socket.AF_UNIX),
            "start a process": _start_process,
            "signal its parent": lambda: os.kill(targets["parent"], 0),
            "change modes of files": lambda: scratch.chmod(0o700),
        },
    }
    return json.dumps(
        {
            layer: [words for words, action in actions.items() if _works(action)]
            for layer, actions in attempts.items()
        }
    ).encode()


def _works(action: Callable[[], object]) -> bool:
    try:
        action()
    except OSError:
        return False
    return True


def _connect(port: int) -> None:
    socket.create_connection(("127.0.0.1", port), timeout=1.0).close()


def _start_process() -> None:
    if os.fork() == 0:
        os._exit(0)
    os.wait()


@contextmanager
def _listener() -> Iterator[int]:
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield int(server.getsockname()[1])
