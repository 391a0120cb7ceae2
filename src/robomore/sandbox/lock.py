"""Puts the layers on this very process, for good. Runs in the child, before any stranger's code."""

from __future__ import annotations

import ctypes
import os
import resource
import signal
import sys
from dataclasses import asdict, dataclass
from typing import Any


class CannotLock(Exception):
    """A layer that was asked for cannot be put on; the message says which and why."""


@dataclass(frozen=True, slots=True)
class Lock:
    """What the child may use.

    Attributes:
        parent: process id of the parent, with which the child ends.
        readable: files and folders that may be read.
        writable: folders that may be written to.
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
        return cls(
            **{
                **fields,
                "readable": tuple(fields["readable"]),
                "writable": tuple(fields["writable"]),
            }
        )


def lock(wanted: Lock) -> list[str]:
    """Put on all layers that this machine has; returns their names.

    Raises:
        CannotLock: a layer is missing and `wanted.strict`.
    """
    names = []
    if _die_with(wanted.parent):
        names.append("ends with its parent")
    _limit(wanted)
    names.append("resource limits")
    return names


def _die_with(parent: int) -> bool:
    """Have the kernel kill this process as its parent ends; says whether the platform can."""
    if sys.platform != "linux":
        return False
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG
    if os.getppid() != parent:  # it ended before we asked
        os._exit(1)
    return True


def _limit(wanted: Lock) -> None:
    """Set limits that no code in this process can raise again."""
    os.umask(0o077)
    limits = {
        resource.RLIMIT_CORE: (0, 0),
        resource.RLIMIT_NOFILE: (256, 256),
        resource.RLIMIT_FSIZE: (wanted.file_bytes, wanted.file_bytes),
        # The soft limit ends the process with a signal of its own, the hard one with SIGKILL.
        resource.RLIMIT_CPU: (wanted.cpu_seconds, wanted.cpu_seconds + 5),
        # Not RLIMIT_AS: XLA and allocators reserve far more addresses than they ever use.
        resource.RLIMIT_DATA: (wanted.memory_bytes, wanted.memory_bytes),
    }
    for which, (soft, hard) in limits.items():
        ceiling = resource.getrlimit(which)[1]
        if ceiling != resource.RLIM_INFINITY:
            soft, hard = min(soft, ceiling), min(hard, ceiling)
        resource.setrlimit(which, (soft, hard))
