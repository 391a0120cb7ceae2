"""Privileges and lifetime of a process: it can lose rights, and it can be made to end."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from pathlib import Path

_PR_SET_PDEATHSIG, _PR_SET_NO_NEW_PRIVS = 1, 38
_CAPABILITY_VERSION = 0x20080522
# Root may work on files whose owner is somebody else (a checkout mounted into a container); which
# files those are is Landlock's to say.
_CAP_DAC_OVERRIDE = 1 << 1


def drop_privileges() -> str:
    """Give up root's special rights, and all ways to get them back.

    Returns:
        What is now enforced, in words.

    Raises:
        OSError: the kernel refuses, or is not Linux.
    """
    _prctl(_PR_SET_NO_NEW_PRIVS, 1)
    kept = _CAP_DAC_OVERRIDE & _capabilities()
    header = (ctypes.c_uint32 * 2)(_CAPABILITY_VERSION, 0)
    sets = (ctypes.c_uint32 * 6)(kept, kept, 0, 0, 0, 0)
    if ctypes.CDLL(None, use_errno=True).capset(header, sets):
        raise OSError(ctypes.get_errno(), "capset failed")
    return "the process has no privileges and cannot gain any"


def end_with_parent(parent: int) -> str:
    """Have the kernel kill this process as soon as its parent ends.

    Args:
        parent: process id. If it has ended already, this process exits at once.

    Returns:
        What is now enforced, in words.

    Raises:
        OSError: the kernel refuses, or is not Linux.
    """
    _prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:  # it ended before we asked
        os._exit(1)
    return "the kernel kills the process when its parent ends"


def _capabilities() -> int:
    """Return the effective capabilities, the first 32 of them."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("CapEff:"):
            return int(line.split()[1], 16) & 0xFFFFFFFF
    return 0


def _prctl(option: int, value: int) -> None:
    if sys.platform != "linux":
        raise OSError("only Linux has this")
    if ctypes.CDLL(None, use_errno=True).prctl(option, value, 0, 0, 0):
        raise OSError(ctypes.get_errno(), "prctl failed")
