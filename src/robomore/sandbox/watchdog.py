"""Decides when a contained child has had enough. Pure: it is told what there is to see."""

from __future__ import annotations

import os
from dataclasses import dataclass

from robomore.sandbox.linux.usage import Usage
from robomore.types import Limits, Status

Verdict = tuple[Status, str]
"""A status and its diagnosis."""

LONGEST_LOOK = 1.0
"""Seconds charged for the time between two looks at most: where more went by, the machine slept or
the parent was stopped, which is not the child's fault."""

_IDLE_FACTOR = 5.0
"""A reward call is charged its processor time; one that computes nothing (it sleeps, or the machine
is crowded) may take this many times the limit, so that load alone never fails an innocent."""
MOST_THREADS = 128 + 4 * (os.cpu_count() or 1)
"""XLA makes some for each core of the machine, whatever it is told."""
_PRINTED_MOST = 64 * 2**20


@dataclass(frozen=True, slots=True)
class Snapshot:
    """What the parent sees of the child at one look.

    Attributes:
        call: number of the reward call that is going on (see `pulse`), 0 for none.
        progress: the latest progress told, `None` before any.
        printed: bytes printed so far.
        usage: what the kernel says of it, `None` where that cannot be read.
        left_on_disk: bytes in its folders; `None` where there are too many files to count.
    """

    call: int
    progress: int | None
    printed: int
    usage: Usage | None
    left_on_disk: int | None


class Watchdog:
    """Follows one child under `limits`; call `look` some times a second."""

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

    def look(self, seconds: float, sight: Snapshot) -> Verdict | None:
        """Return why the child must end now, or `None`.

        Args:
            seconds: since the last look.
            sight: what there is to see.
        """
        seconds = min(seconds, LONGEST_LOOK)
        return (
            self._wall(seconds)
            or self._call(seconds, sight)
            or self._stall(seconds, sight)
            or self._usage(sight)
            or self._output(sight)
        )

    def _wall(self, seconds: float) -> Verdict | None:
        self._elapsed += seconds
        if self._elapsed > self._limits.wall_seconds:
            limit = self._limits.wall_seconds
            return Status.TIMED_OUT, f"not finished after its {limit:g} s of wall-clock time"
        return None

    def _call(self, seconds: float, sight: Snapshot) -> Verdict | None:
        cpu = sight.usage.cpu if sight.usage else 0.0
        if not sight.call or sight.call != self._call_number:
            self._call_number, self._called, self._cpu_before = sight.call, 0.0, cpu
            return None
        self._called += seconds
        limit = self._limits.reward_call_seconds
        computed = cpu - self._cpu_before if sight.usage else self._called
        if computed > limit or self._called > _IDLE_FACTOR * limit:
            return Status.TIMED_OUT, f"one call of the reward did not return within {limit:g} s"
        return None

    def _stall(self, seconds: float, sight: Snapshot) -> Verdict | None:
        if sight.progress is not None and (self._best is None or sight.progress > self._best):
            self._best, self._stalled = sight.progress, 0.0
            return None
        self._stalled += seconds
        if self._stalled > self._limits.stall_seconds:
            limit = self._limits.stall_seconds
            return Status.TIMED_OUT, f"made no progress for {limit:g} s"
        return None

    def _usage(self, sight: Snapshot) -> Verdict | None:
        if sight.usage is None:
            return None
        if sight.usage.memory > self._limits.memory_bytes:
            limit = self._limits.memory_bytes / 2**20
            return Status.OUT_OF_MEMORY, f"used more than its {limit:.0f} MiB of memory"
        if sight.usage.cpu > self._cpu_seconds:
            return Status.TIMED_OUT, f"used up its {self._cpu_seconds:g} s of processor time"
        if sight.usage.threads > MOST_THREADS:
            return Status.REWARD_FAILED, f"the reward started more than {MOST_THREADS} threads"
        return None

    def _output(self, sight: Snapshot) -> Verdict | None:
        if sight.printed > _PRINTED_MOST:
            return (
                Status.REWARD_FAILED,
                f"printed more than {_PRINTED_MOST >> 20} MiB; a reward must not print",
            )
        most = self._most_on_disk
        if sight.left_on_disk is None or sight.left_on_disk > most:
            return (
                Status.REWARD_FAILED,
                f"left too many files, or more than {most >> 20} MiB of them, in its folder; "
                "a reward must not write files",
            )
        return None
