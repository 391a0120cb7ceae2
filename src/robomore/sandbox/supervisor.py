"""The parent's side of a contained call: feeds the child, listens to it, and ends it in time."""

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

from robomore.sandbox import heartbeat as pulse
from robomore.sandbox.linux.usage import folder_bytes, peak_memory, usage
from robomore.sandbox.lock import Layer
from robomore.sandbox.process import Child
from robomore.sandbox.sanitize import plain
from robomore.sandbox.watchdog import Snapshot, Verdict, Watchdog
from robomore.sandbox.wire import Frames, Kind, MalformedFrame, unpack_number
from robomore.types import Limits, Status

_TICK = 0.2
"""Seconds between two looks at the child."""
_LOOKS_PER_COUNT = 5
"""The folders are counted, and the peak of memory read, at one look in so many."""
_MOST_FILES = 10_000
_TO_END = 2.0
"""Seconds that a child has to end after its last word."""
_TO_TELL = 0.3
"""Seconds that a stuck child has to tell where it is."""
_LOG_TAIL = 64 * 2**10
_CHUNK = 2**16
_LONGEST = 20_000
"""Characters of a diagnosis."""


class Follower:
    """One contained child, from its first byte to its burial.

    Attributes:
        verdict: status and diagnosis, once `follow` has returned.
        reply: what the child claims that the function returned.
        layers: of each, whether it was on.
        refusal: why the child would not start, `None` if it did.
        peak_memory: most bytes resident.
    """

    def __init__(
        self,
        child: Child,
        frames: IO[bytes],
        page: int,
        folders: Sequence[Path],
        limits: Limits,
        cpu_seconds: float,
    ) -> None:
        self.verdict: Verdict | None = None
        self.reply = b""
        self.layers: tuple[Layer, ...] = ()
        self.refusal: str | None = None
        self.peak_memory = 0
        self._child = child
        self._arriving = frames
        self._page = memoryview(mmap.mmap(page, pulse.SIZE)).cast("Q")
        self._folders = folders
        self._limits = limits
        self._cpu_seconds = cpu_seconds
        self._watchdog = Watchdog(limits, cpu_seconds, len(folders))
        self._frames = Frames()
        self._request = memoryview(b"")
        self._progress: int | None = None
        self._log = bytearray()
        self._printed = 0
        self._looks = 0
        self._on_disk: int | None = 0

    @property
    def log(self) -> str:
        """The last of what was printed."""
        return plain(bytes(self._log).decode(errors="replace"))

    def follow(self, request: bytes, on_progress: Callable[[int], None] | None) -> None:
        """Hand over `request` and stay until the child has ended or has to; then bury it."""
        self._request = memoryview(request)
        try:
            self._listen(on_progress or _ignore)
            if self.verdict is not None and self.verdict[0] is Status.TIMED_OUT:
                self.verdict = self._with_place(self.verdict)
            elif self.verdict is not None:
                self._child.ends_within(_TO_END)
        finally:
            self._child.close()
        if self.verdict is None:
            self.verdict = self._post_mortem()

    def _listen(self, on_progress: Callable[[int], None]) -> None:
        told: int | None = None
        looked = time.monotonic()
        with selectors.DefaultSelector() as selector:
            for stream, events, handle in (
                (self._child.stdin, selectors.EVENT_WRITE, self._speak),
                (self._child.printed, selectors.EVENT_READ, self._hear_log),
                (self._arriving, selectors.EVENT_READ, self._hear),
            ):
                os.set_blocking(stream.fileno(), False)
                selector.register(stream, events, handle)
            while self.verdict is None and not self._child.ended():
                for key, _ in selector.select(_TICK):
                    if not key.data():
                        selector.unregister(key.fileobj)
                if (passed := time.monotonic() - looked) >= _TICK:
                    looked += passed
                    self._look(passed)
                    if self._progress is not None and self._progress != told:
                        told = self._progress
                        on_progress(told)
        # It may have ended between its last word and our listening to it.
        while self.verdict is None and self._hear(until_empty=True):
            continue
        self._hear_log()
        if self._progress is not None and self._progress != told:
            on_progress(self._progress)

    def _speak(self) -> bool:
        """Send more of the request; says whether there is more."""
        try:
            self._request = self._request[os.write(self._child.stdin.fileno(), self._request) :]
        except BrokenPipeError:
            self._request = memoryview(b"")
        if not self._request:
            self._child.stdin.close()
        return bool(self._request)

    def _hear(self, until_empty: bool = False) -> bool:
        """Take in frames; says whether there may be more."""
        arrived = self._arriving.read(_CHUNK)
        if arrived is None:
            return not until_empty
        try:
            for kind, body in self._frames.feed(arrived):
                self._take(kind, body)
        except (ValueError, RecursionError) as error:
            self.verdict = Status.CRASHED, f"sent its parent something that is no reply ({error})"
        return bool(arrived)

    def _take(self, kind: Kind, body: bytes) -> None:
        if self.verdict is not None:
            return
        match kind:
            case Kind.LOCKED if not self.layers:
                self.layers = tuple(
                    Layer(*fields)
                    for fields in msgspec.json.decode(body, type=list[tuple[str, bool, str]])
                )
            case Kind.REFUSED if not self.layers:
                self.refusal = body.decode()
                self.verdict = Status.FAILED, self.refusal
            case Kind.PROGRESS:
                self._progress = unpack_number(body)
            case Kind.REPLY:
                self.reply = body
                self.verdict = Status.OK, ""
            case Kind.FAULT:
                status, diagnosis = msgspec.json.decode(body, type=tuple[Status, str])
                if status is Status.OK:
                    raise MalformedFrame("a fault that is none")
                self.verdict = status, plain(diagnosis[:_LONGEST])
            case _:
                raise MalformedFrame(f"an unexpected {kind.name}")

    def _hear_log(self) -> bool:
        """Take in what was printed, of which only the end is kept; says whether there is more."""
        arrived = self._child.printed.read(_CHUNK)
        if arrived:
            self._printed += len(arrived)
            self._log += arrived
            del self._log[:-_LOG_TAIL]
        return arrived != b""

    def _look(self, seconds: float) -> None:
        used = usage(self._child.pid)
        if self._looks % _LOOKS_PER_COUNT == 0:
            counts = [folder_bytes(folder, _MOST_FILES) for folder in self._folders]
            known = [count for count in counts if count is not None]
            self._on_disk = sum(known) if len(known) == len(counts) else None
            self.peak_memory = max(self.peak_memory, peak_memory(self._child.pid))
        if used is not None:
            self.peak_memory = max(self.peak_memory, used.memory)
        self._looks += 1
        sight = Snapshot(self._page[0], self._progress, self._printed, used, self._on_disk)
        self.verdict = self.verdict or self._watchdog.look(seconds, sight)

    def _with_place(self, verdict: Verdict) -> Verdict:
        """Return `verdict` with the line of the reward that the child is in, if it can tell."""
        before = self._printed
        self._child.ask_for_traceback()
        deadline = time.monotonic() + _TO_TELL
        while time.monotonic() < deadline and not self._child.ended():
            time.sleep(0.01)
            self._hear_log()
            if self._printed > before and (found := _PLACE.search(self.log)):
                return verdict[0], f"{verdict[1]} (it was in line {found[1]} of the reward)"
        return verdict

    def _post_mortem(self) -> Verdict:
        """Return what to make of a child that ended without a word."""
        code = self._child.exit_code
        assert code is not None
        said = self.log.strip()[-2_000:]
        words = f"; its last words: {said}" if said else ""
        ending = f"died of {signal.Signals(-code).name}" if code < 0 else f"exit status {code}"
        if -code == signal.SIGXCPU or self._child.cpu_seconds > self._cpu_seconds:
            return Status.TIMED_OUT, f"used up its {self._cpu_seconds:g} s of processor time"
        if code and self.peak_memory > _MOST_OF * self._limits.memory_bytes:
            return (
                Status.OUT_OF_MEMORY,
                f"{ending} with {self.peak_memory >> 20} MiB of its "
                f"{self._limits.memory_bytes >> 20} MiB of memory in use{words}",
            )
        return Status.CRASHED, f"{ending} and no result{words}"


_PLACE = re.compile(r'File "<reward>", line (\d+)')
_MOST_OF = 0.5
"""Share of the memory limit beyond which a violent death is put down to memory."""


def _ignore(units: int) -> None:
    """Takes progress that nobody asked for."""
