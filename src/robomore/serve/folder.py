"""The runs of a folder, read again when they change, and never so often that a run is slower."""

from __future__ import annotations

import logging
import os
import shlex
import threading
import time
from collections.abc import Hashable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from robomore.errors import RoboMoReError
from robomore.monitor.progress import Progress, read_progress
from robomore.runs import Run, load_run
from robomore.store import RunFolder

log = logging.getLogger(__name__)

_DEPTH = 3
_MOST_RUNS = 500
_REST = 3.0
"""After a run was read, nothing is read again for so many times as long as that took."""
_QUIET_SECONDS = 120.0
"""A run that has told nothing for so long is not called running."""

Stamp = tuple[tuple[int, int], ...]
"""Times of change and sizes of some files."""


@dataclass(frozen=True, slots=True)
class Look:
    """What a page that shows a run, or several, is up to date with.

    Attributes:
        now: changes when what is shown does.
        read: what `now` was when it was last read.
        due: whether it would be read now if it were asked for: it is new, and the rest is over.
        progress: changes when the progress does.
    """

    now: Hashable
    read: Hashable
    due: bool
    progress: Hashable


@dataclass(slots=True)
class Watched:
    """A run folder as it was last read.

    Attributes:
        name: path below the folder that is served, with `/`.
        path: of the run folder.
        run: as last read; `None` if it never could be.
        error: why it cannot be read now; empty if it can.
        progress: what the run last told of itself.
    """

    name: str
    path: Path
    run: Run | None = None
    error: str = ""
    progress: Progress | None = None
    _stamp: Hashable = ()
    _rested: float = 0.0
    _lock: threading.Lock = field(default_factory=threading.Lock)

    @property
    def running(self) -> bool:
        """Whether it goes on, as far as can be seen from outside."""
        told = self.progress
        # A clock may differ a little; what is told far ahead of now would go on without end.
        return bool(told and not told.over and abs(time.time() - told.time) < _QUIET_SECONDS)

    def look(self) -> Look:
        """Return what is new in its files, without reading them."""
        files = RunFolder(self.path)
        log = files.ledger.with_name(files.ledger.name + "-wal")
        now = _stamp(files.manifest, files.ledger, log)
        waits = self._lock.locked() or time.monotonic() < self._rested
        return Look(now, self._stamp, now != self._stamp and not waits, _stamp(files.progress))

    def read(self) -> Watched:
        """Bring it up to date, unless it was read a moment ago; returns itself."""
        with self._lock:
            self.progress = read_progress(RunFolder(self.path).progress)
            stamp = self.look().now
            began = time.monotonic()
            if stamp == self._stamp or began < self._rested:
                return self
            try:
                self.run, self.error = load_run(self.path), ""
            except Exception as error:  # noqa: BLE001  # the folder may come from anybody
                self.error = why_not_shown(self.path, error)
            # What was written while it was read is read the next time.
            self._stamp = stamp
            now = time.monotonic()
            self._rested = now + _REST * (now - began)
        return self


def why_not_shown(path: Path, error: Exception) -> str:
    """Return in one line why a run cannot be shown, and what to do; a fault of ours is logged."""
    said = " ".join(str(error).split())
    if isinstance(error, RoboMoReError | OSError):
        return said
    log.error("the run %s cannot be shown", path, exc_info=error)
    return (
        f"it cannot be shown ({type(error).__name__}: {said[:200]}), because its folder is damaged "
        f"or RoboMoRe has a fault; `robomore report {shlex.quote(str(path))} --debug` says where"
    )


class ServedFolder:
    """The runs below a folder, by name. Links are not followed, so nothing else is ever read."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self._known: dict[str, Watched] = {}
        self._lock = threading.Lock()

    def runs(self) -> list[Watched]:
        """Return the runs that are there now, without reading them."""
        found = dict(self._found())
        with self._lock:
            self._known = {
                name: self._known.get(name) or Watched(name, path) for name, path in found.items()
            }
            return [self._known[name] for name in sorted(self._known)]

    def run(self, name: str) -> Watched | None:
        """Return the run of a name that `runs` would list; a name is never taken for a path."""
        return next((one for one in self.runs() if one.name == name), None)

    def look(self) -> Look:
        """Return what is new anywhere in the folder; the progress of a run, too, is shown."""
        looks = {one.name: one.look() for one in self.runs()}
        return Look(
            now=tuple((name, one.now, one.progress) for name, one in looks.items()),
            read=tuple((name, one.read, one.progress) for name, one in looks.items()),
            due=any(one.due for one in looks.values()),
            progress=(),
        )

    def _found(self) -> Iterator[tuple[str, Path]]:
        count = 0
        for path in _folders(self.root, _DEPTH):
            if (path / "run.json").is_file() and not (path / "run.json").is_symlink():
                yield path.relative_to(self.root).as_posix(), path
                count += 1
                if count == _MOST_RUNS:
                    return


def _folders(path: Path, depth: int) -> Iterator[Path]:
    """Yield a folder and those below it, but nothing below a run."""
    yield path
    if depth == 0 or (path / "run.json").exists():
        return
    try:
        with os.scandir(path) as entries:
            inner = sorted(e.name for e in entries if e.is_dir(follow_symlinks=False))
    except OSError:  # it vanished, or may not be read
        return
    for name in inner:
        if not name.startswith("."):
            yield from _folders(path / name, depth - 1)


def _stamp(*paths: Path) -> Stamp:
    found = []
    for path in paths:
        try:
            facts = path.stat(follow_symlinks=False)
            found.append((facts.st_mtime_ns, facts.st_size))
        except OSError:
            found.append((0, -1))
    return tuple(found)
