"""Says what keeps a stranger in on this machine, by trying to get out."""

from __future__ import annotations

import json
import os
import socket
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from robomore.errors import InputError
from robomore.sandbox.contain import Containment, refused, run_contained
from robomore.sandbox.lock import REQUIRED, Layer
from robomore.types import Limits, Status

_TRIES = 2
"""A child that is killed from outside says nothing about the layers."""


def layers() -> list[Layer]:
    """Return each layer, and whether it is on: put on in a child that then tried to get past it."""
    with tempfile.TemporaryDirectory() as folder, _listener() as port:
        secret = Path(folder) / "secret"
        secret.write_text("secret")
        aims = {"secret": str(secret), "port": port, "parent": os.getpid()}
        for _ in range(_TRIES):
            contained = run_contained(
                "robomore.sandbox.layers:attempt",
                json.dumps(aims).encode(),
                Path(folder) / "scratch",
                Limits(wall_seconds=20.0),
                mode=Containment.RELAXED,
            )
            if contained.status is Status.OK:
                break
    if contained.status is not Status.OK:
        said = f"trying it failed: {contained.diagnosis}"
        return [Layer(name, False, said) for name in REQUIRED]
    escapes: dict[str, list[str]] = json.loads(contained.reply)
    environment = Layer("environment", True, "no variable of yours but those of the allow-list")
    watchdog = Layer("watchdog", True, "wall-clock time, one reward call, progress, memory, output")
    return [
        replace(layer, active=False, detail=f"{layer.detail}, yet it could {', '.join(escaped)}")
        if (escaped := escapes.get(layer.name))
        else layer
        for layer in (*contained.layers, environment, watchdog)
    ]


def ensure(mode: Containment) -> list[Layer]:
    """Return the layers, once before a run, so that it refuses at once what it would refuse later.

    Raises:
        InputError: `mode` is strict and a layer that it asks for is missing.
    """
    found = layers()
    lacking = missing(found)
    if lacking and mode is Containment.STRICT:
        raise refused("; ".join(f"no layer for {it.name}: {it.detail}" for it in lacking))
    return found


def missing(found: Sequence[Layer]) -> list[Layer]:
    """Return those of `found` that `Containment.STRICT` asks for and that are off."""
    return [layer for layer in found if layer.name in REQUIRED and not layer.active]


def strict_is_possible() -> bool:
    """Say whether this machine has the layers that `Containment.STRICT` asks for."""
    try:
        ensure(Containment.STRICT)
    except InputError:
        return False
    return True


def attempt(payload: bytes, scratch: Path, report: Callable[[int], None]) -> bytes:
    """Try to get out of the child that this runs in; returns what worked, by layer, as JSON."""
    aims = json.loads(payload)
    secret = Path(aims["secret"])
    attempts: dict[str, dict[str, Callable[[], object]]] = {
        "files": {
            "read a file outside its folder": secret.read_text,
            "list a folder outside its own": lambda: list(secret.parent.iterdir()),
            "write outside its folder": lambda: secret.with_name("left").write_text("x"),
            "remove a file outside its folder": secret.unlink,
        },
        "system calls": {
            "open a connection": lambda: _connect(aims["port"]),
            "make a Unix socket": lambda: socket.socket(socket.AF_UNIX),
            "start a process": _start_process,
            "signal its parent": lambda: os.kill(aims["parent"], 0),
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
