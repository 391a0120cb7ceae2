"""What a running process has used so far, read from /proc; nothing where there is no /proc."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

_TICKS = os.sysconf("SC_CLK_TCK")
_PAGE = os.sysconf("SC_PAGE_SIZE")


@dataclass(frozen=True, slots=True)
class Usage:
    """Of one process, all its threads together.

    Attributes:
        cpu: seconds of processor time, in steps of about 0.01 s.
        memory: bytes resident now.
        peak: most bytes ever resident.
        threads: how many there are.
    """

    cpu: float
    memory: int
    peak: int
    threads: int


def usage(pid: int) -> Usage | None:
    """Return what process `pid` has used, or `None` where that cannot be read."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_text()
        status = Path(f"/proc/{pid}/status").read_text()
    except (OSError, UnicodeDecodeError):
        return None
    # The name in parentheses may itself hold spaces and parentheses. See proc_pid_stat(5).
    fields = stat.rpartition(")")[2].split()
    memory = int(fields[21]) * _PAGE
    return Usage(
        cpu=(int(fields[11]) + int(fields[12])) / _TICKS,
        memory=memory,
        peak=max(memory, _kilobytes(status, "VmHWM:") * 1024),
        threads=int(fields[17]),
    )


def folder_bytes(folder: Path, most_entries: int) -> int | None:
    """Return the disk space that `folder` takes, in bytes, or `None` for too many entries."""
    total = entries = 0
    waiting = [folder]
    while waiting:
        try:
            with os.scandir(waiting.pop()) as found:
                for entry in found:
                    entries += 1
                    if entries > most_entries:
                        return None
                    if entry.is_dir(follow_symlinks=False):
                        waiting.append(Path(entry.path))
                    else:
                        total += entry.stat(follow_symlinks=False).st_blocks * 512
        except OSError:
            continue  # vanished while we looked
    return total


def _kilobytes(status: str, label: str) -> int:
    for line in status.splitlines():
        if line.startswith(label):
            return int(line.split()[1])
    return 0
