"""The parent's side of a sandboxed call: sends the request, reads what comes, enforces limits."""

from __future__ import annotations

import mmap
import os
import re
import selectors
import signal
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import IO

import msgspec

from robomore.processes import signal_name
from robomore.sandbox import heartbeat
from robomore.sandbox.linux.usage import folder_bytes, usage
from robomore.sandbox.process import ChildProcess
from robomore.sandbox.restrictions import Layer
from robomore.sandbox.watchdog import Snapshot, Verdict, Watchdog
from robomore.sandbox.wire import Frames, Kind, MalformedFrame, unpack_number
from robomore.text import sanitize
from robomore.types import Limits, Status

_INTERVAL = 0.2
"""Seconds between two snapshots of the process."""
_SNAPSHOTS_PER_COUNT = 5
"""The files are counted at one snapshot in so many."""
_MOST_FILES = 10_000
_TO_END = 2.0
"""Seconds that the process has to end after its reply."""
_TO_PRINT = 0.3
"""Seconds that a stuck process has to print which line it is in."""
_LOG_TAIL = 64 * 2**10
_CHUNK = 2**16
_LONGEST = 20_000
"""Characters of a diagnosis."""


class Supervisor:
    """Watches one sandboxed process from its first byte until it is reaped.

    Attributes:
        reply: what the process claims that the function returned.
        layers: the sandbox layers, and whether each was on.
        refusal: why the process refused to start, `None` if it started.
        peak_memory: largest resident memory, in bytes.
    """

    def __init__(
        self,
        child: ChildProcess,
        frames: IO[bytes],
        page: int,
        folders: Sequence[Path],
        limits: Limits,
        cpu_seconds: float,
    ) -> None:
        self._verdict: Verdict | None = None
        self.reply = b""
        self.layers: tuple[Layer, ...] = ()
        self.refusal: str | None = None
        self.peak_memory = 0
        self._child = child
        self._replies = frames
        self._page = memoryview(mmap.mmap(page, heartbeat.SIZE)).cast("Q")
        self._folders = folders
        self._limits = limits
        self._cpu_seconds = cpu_seconds
        self._watchdog = Watchdog(limits, cpu_seconds, len(folders))
        self._frames = Frames()
        self._request = memoryview(b"")
        self._progress: int | None = None
        self._log = bytearray()
        self._printed = 0
        self._snapshots = 0
        self._disk_bytes: int | None = 0

    @property
    def log(self) -> str:
        """The end of what was printed."""
        return sanitize(bytes(self._log).decode(errors="replace"))

    def supervise(self, request: bytes, on_progress: Callable[[int], None] | None) -> Verdict:
        """Send `request` and wait until the process has ended or must be ended; then reap it.

        Returns:
            Status and diagnosis.
        """
        self._request = memoryview(request)
        try:
            self._listen(on_progress or _ignore)
            if self._verdict is not None and self._verdict[0] is Status.TIMED_OUT:
                self._verdict = self._with_line(self._verdict)
            elif self._verdict is not None:
                self._child.ends_within(_TO_END)
        finally:
            self._child.close()
        return self._verdict or self._cause_of_death()

    def _listen(self, on_progress: Callable[[int], None]) -> None:
        reported: int | None = None
        checked = time.monotonic()
        with selectors.DefaultSelector() as selector:
            for stream, events, handle in (
                (self._child.stdin, selectors.EVENT_WRITE, self._send),
                (self._child.printed, selectors.EVENT_READ, self._read_log),
                (self._replies, selectors.EVENT_READ, self._read_frames),
            ):
                os.set_blocking(stream.fileno(), False)
                selector.register(stream, events, handle)
            while self._verdict is None and not self._child.ended():
                for key, _ in selector.select(_INTERVAL):
                    if not key.data():
                        selector.unregister(key.fileobj)
                if (passed := time.monotonic() - checked) >= _INTERVAL:
                    checked += passed
                    self._check(passed)
                    if self._progress is not None and self._progress != reported:
                        reported = self._progress
                        on_progress(reported)
        # It may have ended after its last frame was written and before that frame was read.
        while self._verdict is None and self._read_frames(until_empty=True):
            continue
        self._read_log()
        if self._progress is not None and self._progress != reported:
            on_progress(self._progress)

    def _send(self) -> bool:
        """Send more of the request; return whether there is more to send."""
        try:
            self._request = self._request[os.write(self._child.stdin.fileno(), self._request) :]
        except BrokenPipeError:
            self._request = memoryview(b"")
        if not self._request:
            self._child.stdin.close()
        return bool(self._request)

    def _read_frames(self, until_empty: bool = False) -> bool:
        """Read frames; return whether there may be more."""
        arrived = self._replies.read(_CHUNK)
        if arrived is None:
            return not until_empty
        try:
            for kind, body in self._frames.feed(arrived):
                self._take(kind, body)
        except (ValueError, RecursionError) as error:
            self._verdict = Status.CRASHED, f"sent its parent a malformed reply ({error})"
        return bool(arrived)

    def _take(self, kind: Kind, body: bytes) -> None:
        if self._verdict is not None:
            return
        match kind:
            case Kind.LAYERS if not self.layers:
                self.layers = msgspec.json.decode(body, type=tuple[Layer, ...])
            case Kind.REFUSED if not self.layers:
                self.refusal = body.decode()
                self._verdict = Status.FAILED, self.refusal
            case Kind.PROGRESS:
                self._progress = unpack_number(body)
            case Kind.REPLY:
                self.reply = body
                self._verdict = Status.OK, ""
            case Kind.FAULT:
                status, diagnosis = msgspec.json.decode(body, type=tuple[Status, str])
                if status is Status.OK:
                    raise MalformedFrame("a fault that is none")
                self._verdict = status, sanitize(diagnosis[:_LONGEST])
            case _:
                raise MalformedFrame(f"an unexpected {kind.name}")

    def _read_log(self) -> bool:
        """Read what was printed and keep only its end; return whether there may be more."""
        arrived = self._child.printed.read(_CHUNK)
        if arrived:
            self._printed += len(arrived)
            self._log += arrived
            del self._log[:-_LOG_TAIL]
        return arrived != b""

    def _check(self, seconds: float) -> None:
        used = usage(self._child.pid)
        if self._snapshots % _SNAPSHOTS_PER_COUNT == 0:
            counts = [folder_bytes(folder, _MOST_FILES) for folder in self._folders]
            known = [count for count in counts if count is not None]
            self._disk_bytes = sum(known) if len(known) == len(counts) else None
        if used is not None:
            self.peak_memory = max(self.peak_memory, used.memory, used.peak_memory)
        self._snapshots += 1
        snapshot = Snapshot(self._page[0], self._progress, self._printed, used, self._disk_bytes)
        self._verdict = self._verdict or self._watchdog.check(seconds, snapshot)

    def _with_line(self, verdict: Verdict) -> Verdict:
        """Return `verdict` with the line of the reward that is running, if it can be found."""
        before = self._printed
        self._child.ask_for_traceback()
        deadline = time.monotonic() + _TO_PRINT
        while time.monotonic() < deadline and not self._child.ended():
            time.sleep(0.01)
            self._read_log()
            if self._printed > before and (found := _LINE.search(self.log)):
                return verdict[0], f"{verdict[1]} (it was in line {found[1]} of the reward)"
        return verdict

    def _cause_of_death(self) -> Verdict:
        """Return status and diagnosis for a process that ended without a reply."""
        code = self._child.exit_code
        assert code is not None
        printed = self.log.strip()[-2_000:]
        output = f"; its last output: {printed}" if printed else ""
        ending = f"died of {signal_name(-code)}" if code < 0 else f"exit status {code}"
        if -code == signal.SIGXCPU or self._child.cpu_seconds > self._cpu_seconds:
            return Status.TIMED_OUT, f"used up its {self._cpu_seconds:g} s of processor time"
        if code and self.peak_memory > _MEMORY_SHARE * self._limits.memory_bytes:
            return (
                Status.OUT_OF_MEMORY,
                f"{ending} with {self.peak_memory >> 20} MiB of its "
                f"{self._limits.memory_bytes >> 20} MiB of memory in use{output}",
            )
        return Status.CRASHED, f"{ending} and no result{output}"


_LINE = re.compile(r'File "<reward>", line (\d{1,6})\b')
_MEMORY_SHARE = 0.5
"""Share of the memory limit. Memory is taken as the cause of death of a process that used more."""


def _ignore(units: int) -> None:
    """Take progress that nobody asked for."""
