"""Calls a function in a process of its own that can reach nothing but what it is given."""

from __future__ import annotations

import importlib.util
import os
import sys
import sysconfig
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import msgspec

from robomore.errors import InputError
from robomore.sandbox import heartbeat
from robomore.sandbox.plugins import PACKAGES, plugin_files
from robomore.sandbox.process import ChildProcess
from robomore.sandbox.restrictions import Layer, Restrictions
from robomore.sandbox.supervisor import Supervisor
from robomore.types import Limits, Status


class Containment(StrEnum):
    """What to do on a machine that does not offer all sandbox layers."""

    STRICT = "strict"
    """Refuse to start."""
    RELAXED = "relaxed"
    """Run with the layers that are available."""


@dataclass(frozen=True, slots=True)
class SandboxResult:
    """How a sandboxed call ended.

    Attributes:
        status: `OK`, or why there is no reply.
        reply: what the function returned. Untrusted code may have written it, so check its form.
        diagnosis: empty when `OK`; else one paragraph for people and designers alike.
        seconds: processor time used, over all threads.
        peak_memory: largest resident memory, in bytes.
        log: the end of what was printed.
        layers: the sandbox layers, and whether each was on.
    """

    status: Status
    reply: bytes = b""
    diagnosis: str = ""
    seconds: float = 0.0
    peak_memory: int = 0
    log: str = ""
    layers: tuple[Layer, ...] = ()


def run_sandboxed(
    function: str,
    payload: bytes,
    scratch: Path,
    limits: Limits,
    *,
    readable: Sequence[Path] = (),
    writable: Sequence[Path] = (),
    on_progress: Callable[[int], None] | None = None,
    environment: Mapping[str, str] = {},
    mode: Containment = Containment.STRICT,
) -> SandboxResult:
    """Call `function(payload, scratch, report)` in a sandboxed process and return how it ended.

    Args:
        function: `module:name`; called with payload, scratch folder and a function that reports
            progress as an integer; returns bytes.
        payload: passed to the function unchanged.
        scratch: working directory of the process and the folder that it may write to. It is made
            if it is missing, and never emptied here.
        limits: limits of time, memory and files, at which the process is ended.
        readable: files and folders it may read besides Python, its packages and RoboMoRe.
        writable: folders it may write to besides `scratch`; made if missing.
        on_progress: called with the latest progress, a few times a second at most.
        environment: environment variables it gets besides the allow-list. Never pass a secret.
        mode: whether a missing layer is an error.

    The process is killed when the thread that called this ends, however it ends.

    Raises:
        InputError: a layer is missing and `mode` is strict.
    """
    scratch = scratch.resolve()
    folders = [scratch, *(path.resolve() for path in writable)]
    for folder in folders:
        folder.mkdir(parents=True, exist_ok=True)
    cpu_seconds = int(_CPU_PER_WALL * limits.wall_seconds) + 1
    header = {
        "function": function,
        "scratch": str(scratch),
        "modules": [function.partition(":")[0].partition(".")[0], *plugin_files()],
        "restrictions": Restrictions(
            parent=os.getpid(),
            readable=tuple(map(str, _needed(function) | {p.resolve() for p in readable})),
            writable=(os.devnull, *map(str, folders)),
            memory_bytes=limits.memory_bytes,
            file_bytes=limits.file_bytes,
            cpu_seconds=cpu_seconds,
            strict=mode is Containment.STRICT,
        ),
    }
    replies, reply_end = os.pipe()
    with heartbeat.page() as page, os.fdopen(replies, "rb", buffering=0) as frames:
        ends = (reply_end, page)
        try:
            child = ChildProcess(
                [sys.executable, "-P", "-s", "-c", _START, "\n".join(_entries()), *map(str, ends)],
                scratch,
                process_environment(scratch) | dict(environment),
                ends,
            )
        finally:
            os.close(reply_end)
        supervisor = Supervisor(child, frames, page, folders, limits, cpu_seconds)
        status, diagnosis = supervisor.supervise(
            msgspec.json.encode(header) + b"\n" + payload, on_progress
        )
    if supervisor.refusal is not None:
        raise refused(supervisor.refusal)
    return SandboxResult(
        status,
        supervisor.reply if status is Status.OK else b"",
        diagnosis,
        child.cpu_seconds,
        supervisor.peak_memory,
        supervisor.log,
        supervisor.layers,
    )


def refused(why: str) -> InputError:
    """Return the error for a machine on which strict containment is not possible."""
    return InputError(
        f"strict containment is not possible on this machine: {why}; "
        "`--containment relaxed` runs rewards with the layers that are available"
    )


_CPU_PER_WALL = 2.0
"""Processor seconds allowed for each second of the wall-clock limit. Training has one thread,
compiling uses a little more."""

_START = (
    "import sys; sys.path[:] = sys.argv.pop(1).split('\\n'); "
    "from robomore.sandbox.child import main; main(int(sys.argv[1]), int(sys.argv[2]))"
)
"""The process gets our own search path, so that it runs the same code as its parent."""

_THREADS = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "NUMEXPR_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
    "NPROC",  # XLA's own
)


def process_environment(scratch: Path) -> dict[str, str]:
    """Return all environment variables of the process: of ours, only where libraries are found."""
    kept = {name: os.environ[name] for name in ("LD_LIBRARY_PATH",) if name in os.environ}
    return kept | {
        "PATH": os.defpath,
        "HOME": str(scratch),
        "TMPDIR": str(scratch),
        "LANG": "C.UTF-8",
        "TZ": "UTC",
        # Sets of strings must iterate in the same order every time, or sums differ in a digit.
        "PYTHONHASHSEED": "0",
        "PYTHONDONTWRITEBYTECODE": "1",
        "PYTHONUTF8": "1",
        # Nothing is drawn there; see also `child`.
        "MUJOCO_GL": "disabled",
        **dict.fromkeys(_THREADS, "1"),
    }


def _entries() -> list[str]:
    return [entry for entry in sys.path if Path(entry).is_absolute()]


def _needed(function: str) -> set[Path]:
    """Return what must be readable to import Python, packages, RoboMoRe and `function`."""
    entries = [Path(entry) for entry in _entries()]
    needed = {Path(folder) for folder in _SYSTEM}
    needed |= {Path(sysconfig.get_path(name)) for name in ("stdlib", "platstdlib")}
    # Not a whole prefix: somebody's project folder may be one.
    needed |= {Path(prefix) / "lib" for prefix in (sys.prefix, sys.base_prefix)}
    needed |= {entry for entry in entries if entry.name in PACKAGES or entry.suffix == ".zip"}
    needed |= {Path(f) for f in os.environ.get("LD_LIBRARY_PATH", "").split(os.pathsep) if f}
    needed |= {place for places in plugin_files().values() for place in places}
    for package in {"robomore", function.partition(":")[0].partition(".")[0]}:
        spec = importlib.util.find_spec(package)
        if spec is not None and spec.submodule_search_locations:
            needed |= {Path(folder) for folder in spec.submodule_search_locations}
        elif spec is not None and spec.origin is not None:
            needed.add(Path(spec.origin))
    return {path.resolve() for path in needed if path.is_absolute() and path.exists()}


_SYSTEM = (
    *("/lib", "/lib64", "/usr/lib", "/usr/lib64", "/usr/local/lib", "/nix/store", "/gnu/store"),
    *("/etc/ld.so.cache", "/etc/localtime", "/dev/null", "/dev/zero", "/dev/urandom"),
    *("/proc/cpuinfo", "/proc/meminfo", "/proc/sys/vm/overcommit_memory"),
    *("/sys/devices/system/cpu", "/sys/devices/system/node"),
)
"""Shared libraries, and what they read about the machine. Nothing that a user may have written."""
