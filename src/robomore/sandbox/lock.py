"""Puts the layers on this very process, for good. Runs in the child, before any stranger's code."""

from __future__ import annotations

import ctypes
import os
import resource
import signal
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from robomore.sandbox.linux import landlock, seccomp

REQUIRED = ("files", "system calls")
"""Layers without which a strict child does not start."""


class CannotLock(Exception):
    """A layer that was asked for cannot be put on; the message says which and why."""


@dataclass(frozen=True, slots=True)
class Layer:
    """One thing that keeps a stranger in.

    Attributes:
        name: what it is about.
        active: whether it is on.
        detail: what does it, or why it is off.
    """

    name: str
    active: bool
    detail: str


@dataclass(frozen=True, slots=True)
class Lock:
    """What the child may use.

    Attributes:
        parent: process id of the parent, with which the child ends.
        readable: files and folders that may be read.
        writable: files and folders that may be written to.
        memory_bytes: of private memory.
        file_bytes: of one file.
        cpu_seconds: of processor time, over all threads.
        strict: whether a missing layer is an error.
    """

    parent: int
    readable: tuple[str, ...]
    writable: tuple[str, ...]
    memory_bytes: int
    file_bytes: int
    cpu_seconds: int
    strict: bool

    def to_json(self) -> dict[str, Any]:
        return asdict(self)

    @classmethod
    def from_json(cls, fields: dict[str, Any]) -> Lock:
        lists = {name: tuple(fields[name]) for name in ("readable", "writable")}
        return cls(**{**fields, **lists})


def lock(wanted: Lock) -> list[Layer]:
    """Put on all layers that this machine has, and say of each whether it is on.

    Raises:
        CannotLock: one of `REQUIRED` is missing and `wanted.strict`.
    """
    layers = [
        _put_on("parent's end", lambda: _end_with(wanted.parent)),
        _put_on("limits", lambda: _limit(wanted)),
        _put_on("privileges", _drop_privileges),
        _put_on("files", lambda: _confine(wanted)),
        _put_on("system calls", seccomp.restrict),
    ]
    missing = [layer for layer in layers if layer.name in REQUIRED and not layer.active]
    if missing and wanted.strict:
        raise CannotLock("; ".join(f"no layer for {it.name}: {it.detail}" for it in missing))
    return layers


def _put_on(name: str, layer: Callable[[], str]) -> Layer:
    try:
        return Layer(name, True, layer())
    except (OSError, ValueError) as error:
        return Layer(name, False, str(error))


def _end_with(parent: int) -> str:
    """Have the kernel kill this process as its parent ends."""
    _prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:  # it ended before we asked
        os._exit(1)
    return "the kernel kills it when its parent ends"


def _limit(wanted: Lock) -> str:
    """Set limits that code in this process cannot raise again."""
    os.umask(0o077)
    data = wanted.memory_bytes + _STACKS * (os.cpu_count() or 1)
    limits = {
        resource.RLIMIT_CORE: (0, 0),
        resource.RLIMIT_NOFILE: (_FILES, _FILES),
        resource.RLIMIT_FSIZE: (wanted.file_bytes, wanted.file_bytes),
        # The soft limit ends the process with a signal of its own, the hard one with SIGKILL.
        resource.RLIMIT_CPU: (wanted.cpu_seconds, wanted.cpu_seconds + 5),
        # Not RLIMIT_AS: XLA and allocators reserve far more addresses than they ever use. What
        # counts is resident memory, which the parent watches; this stops a jump between two looks.
        resource.RLIMIT_DATA: (data, data),
    }
    if (tasks := _tasks_now()) is not None:
        # Counted over all that the user runs, so only a bound on what runs away; not for root.
        limits[resource.RLIMIT_NPROC] = (tasks + _TASKS, tasks + _TASKS)
    for which, (soft, hard) in limits.items():
        ceiling = resource.getrlimit(which)[1]
        if ceiling != resource.RLIM_INFINITY:
            soft, hard = min(soft, ceiling), min(hard, ceiling)
        resource.setrlimit(which, (soft, hard))
    return (
        f"{wanted.memory_bytes >> 20} MiB of memory, {wanted.cpu_seconds} s of processor time, "
        f"files of {wanted.file_bytes >> 20} MiB, {_FILES} open files"
    )


def _drop_privileges() -> str:
    """Give up what root may do and others may not, and all ways to get it back."""
    _prctl(_PR_SET_NO_NEW_PRIVS, 1)
    kept = _CAP_DAC_OVERRIDE & _capabilities()
    header = (ctypes.c_uint32 * 2)(_CAPABILITY_VERSION, 0)
    sets = (ctypes.c_uint32 * 6)(kept, kept, 0, 0, 0, 0)
    if ctypes.CDLL(None, use_errno=True).capset(header, sets):
        raise OSError(ctypes.get_errno(), "capset failed")
    return "none, and none to be gained"


def _confine(wanted: Lock) -> str:
    """Landlock holds for one thread and those it starts, so there must be no other yet."""
    threads = len(list(Path("/proc/self/task").iterdir())) if landlock.version() else 1
    if threads != 1:
        raise OSError(f"{threads} threads are running already")
    return landlock.restrict(wanted.readable, wanted.writable)


def _capabilities() -> int:
    """Return the effective capabilities, the first 32 of them."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("CapEff:"):
            return int(line.split()[1], 16) & 0xFFFFFFFF
    return 0


def _tasks_now() -> int | None:
    """Return how many processes and threads the machine runs, `None` where it does not say."""
    try:
        return int(Path("/proc/loadavg").read_text().split()[3].partition("/")[2])
    except (OSError, ValueError, IndexError):
        return None


def _prctl(option: int, value: int) -> None:
    if sys.platform != "linux":
        raise OSError("only Linux has this")
    if ctypes.CDLL(None, use_errno=True).prctl(option, value, 0, 0, 0):
        raise OSError(ctypes.get_errno(), "prctl failed")


_FILES = 256
_STACKS = 4 * 8 * 2**20
"""Bytes set aside for the stacks of the threads that libraries start for each core."""
_TASKS = 1024
_PR_SET_PDEATHSIG, _PR_SET_NO_NEW_PRIVS = 1, 38
_CAPABILITY_VERSION = 0x20080522
# Root may work on files whose owner is somebody else (a checkout mounted into a container); which
# files those are is Landlock's to say.
_CAP_DAC_OVERRIDE = 1 << 1
