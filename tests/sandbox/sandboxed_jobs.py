"""Functions that the tests run in a sandboxed process."""

from __future__ import annotations

import ctypes
import json
import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

from robomore.errors import (
    InvalidMorphology,
    InvalidReward,
    RewardFailed,
    TrainingDiverged,
    UnstableSimulation,
)

Report = Callable[[int], None]

FAULTS = {
    "invalid-morphology": InvalidMorphology("leg too long"),
    "invalid-reward": InvalidReward("line 1"),
    "reward-failed": RewardFailed("it raised"),
    "unstable": UnstableSimulation("it flew"),
    "training-diverged": TrainingDiverged("nan"),
    "out-of-memory": MemoryError("no more"),
    "failed": ValueError("our own fault"),
}


def echo(payload: bytes, scratch: Path, report: Report) -> bytes:
    report(1)
    report(2)
    return payload


def fail(payload: bytes, scratch: Path, report: Report) -> bytes:
    raise FAULTS[payload.decode()]


def fail_for_memory(payload: bytes, scratch: Path, report: Report) -> bytes:
    raise RewardFailed("The reward raised MemoryError.") from MemoryError()


def no_bytes(payload: bytes, scratch: Path, report: Report) -> bytes:
    return "text"  # type: ignore[return-value]


def surroundings(payload: bytes, scratch: Path, report: Report) -> bytes:
    found = {
        "environment": dict(os.environ),
        "folder": str(Path.cwd()),
        "order": list({f"name{n}" for n in range(50)}),
        "stdin": sys.stdin.read(),
        "descriptors": len(list(_descriptors())),
    }
    return json.dumps(found).encode()


def end(payload: bytes, scratch: Path, report: Report) -> bytes:
    if payload == b"exit":
        os._exit(3)
    os.write(2, b"last output")
    name = payload.decode()
    os.kill(os.getpid(), int(name) if name.isdigit() else getattr(signal, name))
    return b""


def talk(payload: bytes, scratch: Path, report: Report) -> bytes:
    for _ in range(int(payload)):
        os.write(1, b"x" * 2**20)
    os.write(2, b"the end\x1b[2J")
    return b""


def hoard(payload: bytes, scratch: Path, report: Report) -> bytes:
    kept = []
    while True:
        kept.append(bytearray(20_000_000))
        time.sleep(0.02)


def sleep(payload: bytes, scratch: Path, report: Report) -> bytes:
    (scratch / "pid").write_text(str(os.getpid()))
    step = 0
    while True:
        time.sleep(0.05)
        step += 1
        if payload == b"report":
            report(step)


def touch(payload: bytes, scratch: Path, report: Report) -> bytes:
    """Read from and write to each folder named, and return what worked."""
    worked = {}
    for name in json.loads(payload):
        folder = Path(name)
        worked[name] = [_works(lambda f=folder: (f / "old").read_text())]
        worked[name] += [_works(lambda f=folder: (f / "new").write_text("x"))]
    return json.dumps(worked).encode()


def many_threads(payload: bytes, scratch: Path, report: Report) -> bytes:
    counts: list[int] = []
    threads = [threading.Thread(target=counts.append, args=(n,)) for n in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return json.dumps(sorted(counts)).encode()


def heavy(payload: bytes, scratch: Path, report: Report) -> bytes:
    """Compile and run with JAX, and step a model of MuJoCo's."""
    import jax
    import jax.numpy as jnp
    import mujoco

    total = jax.jit(lambda x: (x @ x.T).sum())(jnp.ones((64, 64)))
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body><freejoint/><geom size='.1'/></body></worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 100)
    return json.dumps([float(total), bool(data.qpos[2] < 0.0)]).encode()


def _works(action: Callable[[], object]) -> bool:
    try:
        action()
    except OSError:
        return False
    return True


def _descriptors() -> list[int]:
    found = []
    for descriptor in range(3, 4096):  # its parent may have hundreds open
        try:
            os.fstat(descriptor)
        except OSError:
            continue
        found.append(descriptor)
    return found


def fill(payload: bytes, scratch: Path, report: Callable[[int], None]) -> bytes:
    """Write two files of a megabyte into each folder named, and stay to be caught."""
    for folder in json.loads(payload):
        for name in ("a", "b"):
            (Path(folder) / name).write_bytes(bytes(2**20))
    time.sleep(30)
    return b""


def reserve(payload: bytes, scratch: Path, report: Report) -> bytes:
    """Reserve space beyond the end of a file, which its size does not tell."""
    keep_size = 1
    with (scratch / "file").open("wb") as file:
        arguments = map(ctypes.c_long, (file.fileno(), keep_size, 0, 2**24))
        done = ctypes.CDLL(None, use_errno=True).fallocate(*arguments)
        return json.dumps([done, ctypes.get_errno(), os.fstat(file.fileno()).st_blocks]).encode()


def import_and_read(payload: bytes, scratch: Path, report: Report) -> bytes:
    """Import a task of somebody's own, and read a file of its folder."""
    import own_servo_dog  # type: ignore[import-not-found]

    Path(payload.decode()).read_bytes()
    return str(own_servo_dog.TASK).encode()
