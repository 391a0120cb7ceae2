"""What a running process has used so far, read from /proc; nothing where there is no /proc."""

from __future__ import annotations

import os
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

_TICKS = os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True, slots=True)
class Usage:
    """Of one process, all its threads together.

    Attributes:
        cpu: seconds of processor time, in steps of about 0.01 s.
        memory: bytes resident or swapped out now, page tables included.
        threads: how many there are.
        peak_memory: most bytes that were ever resident.
    """

    cpu: float
    memory: int
    threads: int
    peak_memory: int = 0


def usage(pid: int) -> Usage | None:
    """Return what process `pid` has used, or `None` where that cannot be read."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_bytes()
        memory = _memory(pid)
    except OSError:
        return None
    # The name in parentheses may itself hold spaces and parentheses. See proc_pid_stat(5).
    fields = stat.rpartition(b")")[2].split()
    return Usage(
        cpu=(int(fields[11]) + int(fields[12])) / _TICKS,
        memory=sum(memory.get(name, 0) for name in (b"VmRSS", b"VmSwap", b"VmPTE")),
        threads=int(fields[17]),
        peak_memory=memory.get(b"VmHWM", 0),
    )


def _memory(pid: int) -> dict[bytes, int]:
    """Return the process's memory by the kernel's names, in bytes; nothing once it has ended.

    Its first thread may end while others go on. Then only they tell of the memory that all share.
    """
    if found := _status(Path(f"/proc/{pid}")):
        return found
    for task in Path(f"/proc/{pid}/task").iterdir():
        # Threads that begin and end all the time must not hide those that stay.
        with suppress(OSError):
            if found := _status(task):
                return found
    return {}


def _status(task: Path) -> dict[bytes, int]:
    lines = [line.split() for line in (task / "status").read_bytes().splitlines()]
    return {line[0][:-1]: int(line[1]) << 10 for line in lines if line[0].startswith(b"Vm")}


def folder_bytes(folder: Path, most_entries: int) -> int | None:
    """Return the disk space that `folder` takes, in bytes.

    It is `None` where that cannot be counted: too many entries, or a folder that nobody can enter
    because its path is too long or its owner gave up the right to.
    """
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
        except (FileNotFoundError, NotADirectoryError):
            continue  # vanished while we looked
        except OSError:
            return None
    return total
