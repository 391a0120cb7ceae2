"""Restricts this very process, for good. Runs in the sandboxed process before untrusted code."""

from __future__ import annotations

import os
import resource
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from robomore.sandbox.linux import landlock, seccomp
from robomore.sandbox.linux.privileges import drop_privileges, end_with_parent

REQUIRED = ("parent's end", "limits", "privileges", "files", "system calls")
"""Layers without which untrusted code does not start under strict containment."""


class LayerMissing(Exception):
    """A required layer is not available; the message says which one and why."""


@dataclass(frozen=True, slots=True)
class Layer:
    """One of the protections that keep untrusted code in.

    Attributes:
        name: what it protects or limits.
        active: whether it is on.
        detail: what enforces it, or why it is off.
    """

    name: str
    active: bool
    detail: str


@dataclass(frozen=True, slots=True)
class Restrictions:
    """What the sandboxed process may use.

    Attributes:
        parent: process id of its parent, together with which it ends.
        readable: files and folders that it may read.
        writable: files and folders that it may write to.
        memory_bytes: limit of its private memory.
        file_bytes: limit of the size of one file.
        cpu_seconds: limit of its processor time, over all threads.
        strict: whether a missing layer is an error.
    """

    parent: int
    readable: tuple[str, ...]
    writable: tuple[str, ...]
    memory_bytes: int
    file_bytes: int
    cpu_seconds: int
    strict: bool


def apply_restrictions(wanted: Restrictions) -> list[Layer]:
    """Turn on all layers that this machine offers, and say of each whether it is on.

    Raises:
        LayerMissing: one of `REQUIRED` is off and `wanted.strict`.
    """
    layers = [
        _turn_on("parent's end", lambda: end_with_parent(wanted.parent)),
        _turn_on("limits", lambda: _limit(wanted)),
        _turn_on("privileges", drop_privileges),
        _turn_on("files", lambda: _restrict_files(wanted)),
        _turn_on("system calls", seccomp.restrict),
    ]
    if wanted.strict and (lacking := missing(layers)):
        raise LayerMissing(describe(lacking))
    return layers


def missing(layers: Iterable[Layer]) -> list[Layer]:
    """Return those of `layers` that are required under strict containment and off."""
    return [layer for layer in layers if layer.name in REQUIRED and not layer.active]


def describe(lacking: Iterable[Layer]) -> str:
    """Return which layers are missing and why, as one line."""
    return "; ".join(f"the layer for {it.name} is missing ({it.detail})" for it in lacking)


def _turn_on(name: str, layer: Callable[[], str]) -> Layer:
    try:
        return Layer(name, True, layer())
    except (OSError, ValueError) as error:
        return Layer(name, False, str(error))


def _limit(wanted: Restrictions) -> str:
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


def _restrict_files(wanted: Restrictions) -> str:
    """Landlock holds for one thread and those it starts, so there must be no other yet."""
    threads = len(list(Path("/proc/self/task").iterdir())) if landlock.version() else 1
    if threads != 1:
        raise OSError(f"{threads} threads are running already")
    return landlock.restrict(wanted.readable, wanted.writable)


def _tasks_now() -> int | None:
    """Return how many processes and threads the machine runs, `None` where it does not say."""
    try:
        return int(Path("/proc/loadavg").read_text().split()[3].partition("/")[2])
    except (OSError, ValueError, IndexError):
        return None


_FILES = 256
_STACKS = 4 * 8 * 2**20
"""Bytes set aside for the stacks of the threads that libraries start for each core."""
_TASKS = 1024
