"""A seccomp filter: from now on the kernel refuses this process most system calls.

No sockets of any kind, no new processes or programs, no tracing, no signals to others, no change
of limits, owners or modes. A call that is not on the list fails with "Operation not permitted", a
recent one with "Function not implemented", on which the C library falls back to older ones.

The filter is a small program for the kernel's BPF machine, see seccomp(2); it needs no package.
"""

from __future__ import annotations

import ctypes
import errno
import os
import platform
import sys
from collections.abc import Iterable
from typing import NamedTuple

from robomore.sandbox.linux.syscalls import ALLOWED, CONDITIONAL

_MACHINES = {"x86_64": (0, 0xC000003E), "aarch64": (1, 0xC00000B7)}
"""Column in the tables, and the kernel's AUDIT_ARCH number."""

_LOAD, _AND, _RETURN = 0x20, 0x54, 0x06
_EQUAL, _AT_LEAST, _ANY_BIT = 0x15, 0x35, 0x45
_ALLOW, _KILL, _ERRNO = 0x7FFF0000, 0x80000000, 0x00050000
_REFUSE = _ERRNO | errno.EPERM
_UNKNOWN = _ERRNO | errno.ENOSYS
_NUMBER, _MACHINE, _ARGUMENTS = 0, 4, 16
"""Offsets in struct seccomp_data."""

_X32 = 0x40000000
_RECENT = 403
"""From this number on all machines number their calls alike, and C libraries expect absence."""

_THREAD_OF_OURS = 0x00010000 | 0x00000400
"""CLONE_THREAD and CLONE_FILES: a thread with open files of its own could open as many again."""
_OWN_FILES = 0x2
"""CLOSE_RANGE_UNSHARE does the same to a thread that runs already."""
_NEW_NAMESPACE = 0x7E020000
_TRUNCATE, _ACCESS_MODE, _NAMELESS = 0o1000, 0o3, 0o20000000
_SHARED, _ANONYMOUS, _GROWS_DOWN = 0x1, 0x20, 0x100
# Names of threads and of memory, and questions; not the signal on a parent's death, which is set.
_PRCTL = (3, 15, 16, 21, 23, 39, 42, 0x53564D41)
# Is it a terminal, close on exec, blocking, bytes to read; the last is a recent form of the first.
_IOCTL = (0x5401, 0x5413, 0x5421, 0x541B, 0x5450, 0x5451, 0x802C542A)
# Duplicates, flags and pipe size; not the owner that a descriptor sends signals to.
_FCNTL = (0, 1, 2, 3, 4, 1030, 1032)

_SET_FILTER, _ALL_THREADS = 1, 1
_SECCOMP = {"x86_64": 317, "aarch64": 277}


class Instruction(NamedTuple):
    """One step of the BPF machine: jumps count the instructions that are skipped."""

    code: int
    if_true: int
    if_false: int
    value: int


def program(machine: str, pid: int) -> list[Instruction]:
    """Return the filter for processor `machine` and a process of number `pid`.

    Raises:
        OSError: there is no table of system calls for that machine.
    """
    if machine not in _MACHINES:
        raise OSError(f"no table of system calls for a {machine} machine")
    column, audit = _MACHINES[machine]
    steps = [
        Instruction(_LOAD, 0, 0, _MACHINE),
        Instruction(_EQUAL, 1, 0, audit),
        _end(_KILL),  # 32-bit calls on a 64-bit kernel
        Instruction(_LOAD, 0, 0, _NUMBER),
        Instruction(_AT_LEAST, 0, 1, _X32),
        _end(_UNKNOWN),
    ]
    for numbers in ALLOWED.values():
        if (number := numbers[column]) is not None:
            steps += [Instruction(_EQUAL, 0, 1, number), _end(_ALLOW)]
    for name, rule in _conditions(pid).items():
        if (number := CONDITIONAL[name][column]) is not None:
            steps += [Instruction(_EQUAL, 0, len(rule), number), *rule]
    return [*steps, Instruction(_AT_LEAST, 0, 1, _RECENT), _end(_UNKNOWN), _end(_REFUSE)]


def restrict() -> str:
    """Put the filter on all threads of this process, for good. Needs `no_new_privs` to be set.

    Returns:
        What is now enforced, in words.

    Raises:
        OSError: the kernel refuses, has no seccomp, or the machine is unknown.
    """
    if sys.platform != "linux":
        raise OSError("only Linux has seccomp")
    machine = platform.machine()
    install(program(machine, os.getpid()), machine)
    return "seccomp"


def install(steps: list[Instruction], machine: str) -> None:
    """Put a filter on all threads of this process, for good.

    Raises:
        OSError: the kernel refuses, or has no seccomp.
    """
    code = (_Step * len(steps))(*(_Step(*step) for step in steps))
    filter_ = _Program(len(steps), code)
    library = ctypes.CDLL(None, use_errno=True)
    result = library.syscall(
        ctypes.c_long(_SECCOMP[machine]), _SET_FILTER, _ALL_THREADS, ctypes.byref(filter_)
    )
    if result:
        error = ctypes.get_errno()
        raise OSError(error, os.strerror(error) if error else "a thread could not be restricted")


class _Step(ctypes.Structure):
    _fields_ = (
        ("code", ctypes.c_uint16),
        ("if_true", ctypes.c_uint8),
        ("if_false", ctypes.c_uint8),
        ("value", ctypes.c_uint32),
    )


class _Program(ctypes.Structure):
    _fields_ = (("length", ctypes.c_uint16), ("steps", ctypes.POINTER(_Step)))


def _conditions(pid: int) -> dict[str, list[Instruction]]:
    """Return what decides on each call that is allowed with certain arguments only."""
    return {
        "open": _open(1),
        "openat": _open(2),
        # Memory that RLIMIT_DATA does not count: without a file and shared, or growing as a stack.
        "mmap": [
            _argument(3),
            Instruction(_ANY_BIT, 0, 1, _GROWS_DOWN),
            _end(_REFUSE),
            Instruction(_AND, 0, 0, _SHARED | _ANONYMOUS),
            Instruction(_EQUAL, 0, 1, _SHARED | _ANONYMOUS),
            _end(_REFUSE),
            _end(_ALLOW),
        ],
        "clone": [
            _argument(0),
            Instruction(_ANY_BIT, 0, 1, _NEW_NAMESPACE),
            _end(_REFUSE),
            Instruction(_AND, 0, 0, _THREAD_OF_OURS),
            Instruction(_EQUAL, 0, 1, _THREAD_OF_OURS),
            _end(_ALLOW),
            _end(_REFUSE),
        ],
        "close_range": [
            _argument(2),
            Instruction(_ANY_BIT, 0, 1, _OWN_FILES),
            _end(_REFUSE),
            _end(_ALLOW),
        ],
        "prctl": _one_of(0, _PRCTL),
        "ioctl": _one_of(1, _IOCTL),
        "fcntl": _one_of(1, _FCNTL),
        "kill": _one_of(0, (pid,)),
        "tgkill": _one_of(0, (pid,)),
        "sched_setaffinity": _one_of(0, (0, pid)),
        # Asking for limits passes no new ones: both halves of that pointer are zero.
        "prlimit64": [
            _argument(2),
            Instruction(_EQUAL, 1, 0, 0),
            _end(_REFUSE),
            _argument(2, upper=True),
            Instruction(_EQUAL, 1, 0, 0),
            _end(_REFUSE),
            *_one_of(0, (0, pid)),
        ],
    }


def _open(index: int) -> list[Instruction]:
    """Refuse files without a name, which take space that nobody sees.

    Reading alone must not empty a file either, which Landlock before ABI 3 would let happen.
    """
    return [
        _argument(index),
        Instruction(_ANY_BIT, 0, 1, _NAMELESS),
        _end(_REFUSE),
        Instruction(_AND, 0, 0, _TRUNCATE | _ACCESS_MODE),
        Instruction(_EQUAL, 0, 1, _TRUNCATE),
        _end(_REFUSE),
        _end(_ALLOW),
    ]


def _one_of(index: int, values: Iterable[int]) -> list[Instruction]:
    steps = [_argument(index)]
    for value in values:
        steps += [Instruction(_EQUAL, 0, 1, value), _end(_ALLOW)]
    return [*steps, _end(_REFUSE)]


def _argument(index: int, upper: bool = False) -> Instruction:
    """Load one half of an argument; both machines store the lower half first."""
    return Instruction(_LOAD, 0, 0, _ARGUMENTS + 8 * index + 4 * upper)


def _end(action: int) -> Instruction:
    return Instruction(_RETURN, 0, 0, action)
