"""A run's folder: the one place that knows file names (docs/runs.md describes every file)."""

from __future__ import annotations

import sqlite3
from contextlib import closing, suppress
from pathlib import Path

from robomore.errors import RoboMoReError, RunFolderError, StorageFailed
from robomore.plain_files import PARTIAL, PlainFolder, what_stands_at
from robomore.store.exchanges import LedgerExchanges
from robomore.store.ledger import Ledger
from robomore.store.manifest import Manifest
from robomore.store.opening import refuse_unsafe
from robomore.suggestions import path_meant

TASK_CONTENT = "task.json"
"""File that holds a task of a file whole, in a run's folder and beside a design."""

_PROBE_BYTES = 4 * 2**20
_FOLDERS = {"artifacts": 2, "checkpoints": 2, "scratch": 1, "champion": 1}
"""Folders in a run's folder, and how many levels of each are used."""


def refuse_no_folder(path: Path, remedy: str) -> None:
    """Refuse a path at which there is no folder.

    Args:
        path: that was given.
        remedy: which folder to name.

    Raises:
        RunFolderError: saying what is there, or which name was meant.
    """
    found = what_stands_at(path)
    if found != "a folder":
        said = f"{path} is {found}" if found else f"there is no folder {path}"
        hint = path_meant(path)
        raise RunFolderError(f"{said}.{hint} Name {remedy}" if hint else f"{said}; name {remedy}")


class RunFolder:
    """The files of one run.

    ```
    run.json          what was asked for (Manifest)
    task.json         the task, if it came from a task file
    ledger.sqlite     proposals, evaluations, exchanges, events
    artifacts/KEY/    policy.npz of an evaluation
    checkpoints/      trainings that rest between two rungs of screening
    scratch/          what is being trained right now; empty when nothing runs
    champion/         the answer: design.json, reward.py, robot.xml, policy.npz, SHA256SUMS
    report.html       the answer as a page
    progress.json     how far the run is, for `robomore serve`
    lock              held while the run goes on
    ```
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.manifest = path / "run.json"
        self.task = path / TASK_CONTENT
        self.ledger = path / "ledger.sqlite"
        self.artifacts = path / "artifacts"
        self.scratch = path / "scratch"
        self.checkpoints = path / "checkpoints"
        self.champion = path / "champion"
        self.report = path / "report.html"
        self.progress = path / "progress.json"
        self.hint = path / "hint.txt"
        self._lock = path / "lock"
        self._probe = path / "probe.partial"
        self._held: sqlite3.Connection | None = None

    @property
    def files(self) -> PlainFolder:
        """What is in the folder, read, written and removed without following links."""
        return PlainFolder(self.path)

    @classmethod
    def existing(cls, path: Path) -> RunFolder:
        """Return the folder of a run that was started before.

        Raises:
            RunFolderError: there is none, or something in it is no plain file.
        """
        remedy = "a folder that `robomore run` wrote"
        refuse_no_folder(path, remedy)
        folder = cls(path)
        if not folder.files.is_file(folder.manifest.name):
            raise RunFolderError(
                f"{path} is not a run folder (it has no {folder.manifest.name}); name {remedy}"
            )
        folder.refuse_links()
        return folder

    @classmethod
    def prepare(cls, path: Path, asked: Manifest) -> RunFolder:
        """Return the folder of a new run, or of the same run to be continued; hold its lock.

        Raises:
            RunFolderError: not writable, in use, the folder of another run, or with something in
                it that is no plain file.
        """
        folder = cls(path)
        try:
            path.mkdir(parents=True, exist_ok=True)
            folder.refuse_links()
            folder._refuse_foreign_files()
            for inner in (folder.artifacts, folder.checkpoints, folder.scratch):
                folder.files.make(inner.name)
            # SQLite opens what it may not write to, and says nothing before it has to write.
            folder.files.write(folder._probe.name, b"")
            folder.files.remove(folder._probe.name)
            folder._hold_lock()
            folder._remove_partial_files()
            if folder.files.is_file(folder.manifest.name):
                folder._refuse_another_run(asked)
            else:
                if folder.files.is_file(folder.ledger.name):
                    raise RunFolderError(
                        f"{path} has a ledger but no {folder.manifest.name}; "
                        "choose another folder with --out"
                    )
                asked.save(folder.manifest)
            folder.empty_scratch()
        except OSError as error:
            raise RunFolderError(
                f"cannot write to {path} ({error.strerror}); choose another folder with --out"
            ) from None
        except RunFolderError:
            folder.release()
            raise
        return folder

    def ensure_writable(self) -> None:
        """Make sure that what went wrong is not the disk's fault, before a design is blamed.

        Raises:
            StorageFailed: no file of a policy's size can be written now.
        """
        try:
            self.files.write(self._probe.name, bytes(_PROBE_BYTES), to_disk=True)
        except OSError as error:
            raise StorageFailed(
                f"cannot write to {self.path} ({error.strerror}); free disk space or make the "
                "folder writable, then the same command goes on: everything that was finished is "
                "kept"
            ) from None
        finally:
            with suppress(OSError):
                self.files.remove(self._probe.name)

    def refuse_links(self) -> None:
        """Refuse the folder if a name that a run uses is taken by a link, a pipe or a device.

        A folder may come from somebody else, and a link in it would lead to other files.

        Raises:
            RunFolderError: naming it.
        """
        used = ("run.", "task.", "ledger", "lock", "probe", "report", "hint", *_FOLDERS)
        for name in self.files.names():
            if name.startswith(used) or name.endswith(".partial"):
                self.files.kind(name)
        for name, depth in _FOLDERS.items():
            self.files.check(name, depth)

    def _refuse_foreign_files(self) -> None:
        """Refuse a folder that holds something and is no run's: a run empties folders in it.

        What a run leaves that ended before its manifest was written is no obstacle.

        Raises:
            RunFolderError: naming what is there.
        """
        if self.files.is_file(self.manifest.name) or self.files.is_file(self.ledger.name):
            return
        begun = (self._lock.name, self._probe.name, self.hint.name)
        for name in self.files.names():
            if name.startswith(".") or name in begun:
                continue
            if name not in _FOLDERS or self.files.names(name):
                raise RunFolderError(
                    f"{self.path} is not empty ({name} is in it) and not the folder of a run; "
                    "name a new folder with --out"
                )

    def _refuse_another_run(self, asked: Manifest) -> None:
        """Refuse the folder of another run, unless that one ended before it had kept anything.

        It may have had no more than a wrong URL of a model, which is corrected now.

        Raises:
            RunFolderError: naming what differs.
        """
        kept = Manifest.load(self.manifest)
        try:
            kept.refuse_other(asked, self.path)
        except RunFolderError:
            if not self._keeps_nothing():
                raise
            for name in self.files.names():
                if name.startswith((self.ledger.name, self.task.name)):
                    self.files.remove(name)
            asked.save(self.manifest)

    def _keeps_nothing(self) -> bool:
        """Return whether no answer, no proposal and no evaluation is in the folder."""
        if any(self.files.names(name) for name in _FOLDERS):
            return False
        if not self.files.is_file(self.ledger.name):
            return True
        try:
            with (
                closing(Ledger(self.ledger, read_only=True)) as ledger,
                closing(LedgerExchanges(self.ledger, read_only=True)) as exchanges,
            ):
                return not (exchanges.all() or ledger.proposals() or ledger.evaluations())
        except RoboMoReError:
            return False  # what cannot be read may be worth something

    def empty_scratch(self) -> None:
        """Remove what trainings that were stopped or killed left, as far as that is possible."""
        with suppress(OSError, RunFolderError):
            for name in self.files.names(self.scratch.name):
                self.files.remove(f"{self.scratch.name}/{name}")

    def _remove_partial_files(self) -> None:
        """Remove files that a killed run had begun to write. A page may be written right now."""
        for above in ("", *_FOLDERS):
            for name in self.files.names(above):
                if PARTIAL.fullmatch(name) and not name.startswith(".report"):
                    self.files.remove(f"{above}/{name}" if above else name)

    def release(self) -> None:
        """Let go of the lock."""
        if self._held is not None:
            self._held.close()
            self._held = None

    def _hold_lock(self) -> None:
        """Take the folder for this process.

        SQLite's own file lock works on every platform and falls with the process, however it ends.
        """
        refuse_unsafe(self._lock, to_write=True)
        connection = sqlite3.connect(self._lock, timeout=0, isolation_level=None)
        try:
            connection.execute("PRAGMA journal_mode=MEMORY")
            connection.execute("BEGIN EXCLUSIVE")
        except sqlite3.Error as error:
            connection.close()
            if "locked" in str(error):
                raise RunFolderError(
                    f"{self.path} is in use by another run; wait for it, or choose another folder "
                    "with --out"
                ) from None
            raise RunFolderError(
                f"cannot write to {self._lock} ({error}); remove that file, or choose another "
                "folder with --out"
            ) from None
        self._held = connection
