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
        threads: how many there are.
    """

    cpu: float
    memory: int
    threads: int


def usage(pid: int) -> Usage | None:
    """Return what process `pid` has used, or `None` where that cannot be read."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_bytes()
    except OSError:
        return None
    # The name in parentheses may itself hold spaces and parentheses. See proc_pid_stat(5).
    fields = stat.rpartition(b")")[2].split()
    return Usage(
        cpu=(int(fields[11]) + int(fields[12])) / _TICKS,
        memory=int(fields[21]) * _PAGE,
        threads=int(fields[17]),
    )


def peak_memory(pid: int) -> int:
    """Return the most bytes that process `pid` ever had resident, 0 where that cannot be read."""
    try:
        status = Path(f"/proc/{pid}/status").read_bytes()
    except OSError:
        return 0
    lines = [line for line in status.splitlines() if line.startswith(b"VmHWM:")]
    return int(lines[0].split()[1]) * 1024 if lines else 0


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
