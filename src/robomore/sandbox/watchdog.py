"""Decides when a sandboxed process must be ended. Pure: it is given snapshots of the process."""

from __future__ import annotations

import os
from dataclasses import dataclass

from robomore.sandbox.linux.usage import Usage
from robomore.types import Limits, Status

Verdict = tuple[Status, str]
"""A status and its diagnosis."""

LONGEST_INTERVAL = 1.0
"""Most seconds charged for the time between two snapshots. Where more went by, the machine slept or
the parent was stopped, which is not the fault of the sandboxed process."""

_IDLE_FACTOR = 5.0
"""A reward call is charged its processor time. One that computes nothing (it sleeps, or the machine
is busy) may take this many times the limit, so that a busy machine alone never fails a reward."""
MOST_THREADS = 128 + 4 * (os.cpu_count() or 1)
"""XLA starts some for each core of the machine, whatever it is told."""
_PRINTED_MOST = 64 * 2**20


@dataclass(frozen=True, slots=True)
class Snapshot:
    """What the parent sees of the sandboxed process at one moment.

    Attributes:
        call: number of the reward call that is going on (see `heartbeat`), 0 for none.
        progress: the latest progress reported, `None` before the first.
        printed: bytes printed so far.
        usage: processor time, memory and threads; `None` where they cannot be read.
        disk_bytes: size of all files in its folders; `None` where there are too many to count.
    """

    call: int
    progress: int | None
    printed: int
    usage: Usage | None
    disk_bytes: int | None


class Watchdog:
    """Enforces `limits` on one sandboxed process. Call `check` a few times a second."""

    def __init__(self, limits: Limits, cpu_seconds: float, folders: int = 1) -> None:
        self._limits = limits
        # A checkpoint is written beside the one before it.
        self._most_on_disk = (1 + folders) * limits.file_bytes
        self._cpu_seconds = cpu_seconds
        self._elapsed = 0.0
        self._best: int | None = None
        self._stalled = 0.0
        self._call_number = 0
        self._called = 0.0
        self._cpu_before = 0.0

    def check(self, seconds: float, snapshot: Snapshot) -> Verdict | None:
        """Return why the process must be ended now, or `None`.

        Args:
            seconds: since the last snapshot.
            snapshot: what the process has done and used by now.
        """
        seconds = min(seconds, LONGEST_INTERVAL)
        return (
            self._wall(seconds)
            or self._call(seconds, snapshot)
            or self._stall(seconds, snapshot)
            or self._usage(snapshot)
            or self._output(snapshot)
        )

    def _wall(self, seconds: float) -> Verdict | None:
        self._elapsed += seconds
        if self._elapsed > self._limits.wall_seconds:
            limit = self._limits.wall_seconds
            return Status.TIMED_OUT, f"not finished after its {limit:g} s of wall-clock time"
        return None

    def _call(self, seconds: float, snapshot: Snapshot) -> Verdict | None:
        cpu = snapshot.usage.cpu if snapshot.usage else 0.0
        if not snapshot.call or snapshot.call != self._call_number:
            self._call_number, self._called, self._cpu_before = snapshot.call, 0.0, cpu
            return None
        self._called += seconds
        limit = self._limits.reward_call_seconds
        computed = cpu - self._cpu_before if snapshot.usage else self._called
        if computed > limit or self._called > _IDLE_FACTOR * limit:
            return Status.TIMED_OUT, f"one call of the reward did not return within {limit:g} s"
        return None

    def _stall(self, seconds: float, snapshot: Snapshot) -> Verdict | None:
        if snapshot.progress is not None and (self._best is None or snapshot.progress > self._best):
            self._best, self._stalled = snapshot.progress, 0.0
            return None
        self._stalled += seconds
        if self._stalled > self._limits.stall_seconds:
            limit = self._limits.stall_seconds
            return Status.TIMED_OUT, f"made no progress for {limit:g} s"
        return None

    def _usage(self, snapshot: Snapshot) -> Verdict | None:
        if snapshot.usage is None:
            return None
        if snapshot.usage.memory > self._limits.memory_bytes:
            limit = self._limits.memory_bytes / 2**20
            return Status.OUT_OF_MEMORY, f"used more than its {limit:.0f} MiB of memory"
        if snapshot.usage.cpu > self._cpu_seconds:
            return Status.TIMED_OUT, f"used up its {self._cpu_seconds:g} s of processor time"
        if snapshot.usage.threads > MOST_THREADS:
            return Status.REWARD_FAILED, f"the reward started more than {MOST_THREADS} threads"
        return None

    def _output(self, snapshot: Snapshot) -> Verdict | None:
        if snapshot.printed > _PRINTED_MOST:
            return (
                Status.REWARD_FAILED,
                f"printed more than {_PRINTED_MOST >> 20} MiB; a reward must not print",
            )
        most = self._most_on_disk
        if snapshot.disk_bytes is None or snapshot.disk_bytes > most:
            return (
                Status.REWARD_FAILED,
                f"left too many files, or more than {most >> 20} MiB of them, in its folder; "
                "a reward must not write files",
            )
        return None
