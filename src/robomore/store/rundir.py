"""A run's folder: the one place that knows file names (docs/runs.md describes every file)."""

from __future__ import annotations

import os
import sqlite3
from contextlib import suppress
from pathlib import Path

from robomore.errors import RunFolderError, StorageFailed
from robomore.store.manifest import Manifest

_PROBE_BYTES = 4 * 2**20


class RunFolder:
    """The files of one run.

    ```
    run.json          what was asked for (Manifest)
    ledger.sqlite     proposals, evaluations, exchanges, events
    artifacts/KEY/    policy.npz of an evaluation
    checkpoints/      trainings that rest between two rungs of screening
    scratch/          what is being trained right now; empty when nothing runs
    champion/         the answer: design.json, reward.py, robot.xml, policy.npz, SHA256SUMS
    report.html       the answer as a page
    lock              held while the run goes on
    ```
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.manifest = path / "run.json"
        self.ledger = path / "ledger.sqlite"
        self.artifacts = path / "artifacts"
        self.scratch = path / "scratch"
        self.checkpoints = path / "checkpoints"
        self.champion = path / "champion"
        self.report = path / "report.html"
        self._lock = path / "lock"
        self._probe = path / "probe.partial"
        self._held: sqlite3.Connection | None = None

    @classmethod
    def existing(cls, path: Path) -> RunFolder:
        """Return the folder of a run that was started before.

        Raises:
            RunFolderError: there is none.
        """
        folder = cls(path)
        if not folder.manifest.is_file():
            raise RunFolderError(
                f"{path} is not a run folder (it has no {folder.manifest.name}); "
                "name a folder that `robomore run` wrote"
            )
        return folder

    @classmethod
    def prepare(cls, path: Path, asked: Manifest) -> RunFolder:
        """Return the folder of a new run, or of the same run to be continued; hold its lock.

        Raises:
            RunFolderError: not writable, in use, or the folder of another run.
        """
        folder = cls(path)
        try:
            folder.artifacts.mkdir(parents=True, exist_ok=True)
            # SQLite opens what it may not write to, and says nothing before it has to write.
            folder._probe.touch()
            folder._probe.unlink()
            folder._hold_lock()
            if folder.manifest.exists():
                Manifest.load(folder.manifest).refuse_other(asked, path)
            else:
                if folder.ledger.exists():
                    raise RunFolderError(
                        f"{path} has a ledger but no {folder.manifest.name}; "
                        "choose another folder with --out"
                    )
                asked.save(folder.manifest)
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
            with self._probe.open("wb") as file:
                file.write(bytes(_PROBE_BYTES))
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            raise StorageFailed(
                f"cannot write to {self.path} ({error.strerror}); free disk space or make the "
                "folder writable, then the same command goes on: everything that was finished is "
                "kept"
            ) from None
        finally:
            with suppress(OSError):
                self._probe.unlink(missing_ok=True)

    def release(self) -> None:
        """Let go of the lock."""
        if self._held is not None:
            self._held.close()
            self._held = None

    def _hold_lock(self) -> None:
        """Take the folder for this process.

        SQLite's own file lock works on every platform and falls with the process, however it ends.
        """
        connection = sqlite3.connect(self._lock, timeout=0, isolation_level=None)
        try:
            connection.execute("BEGIN EXCLUSIVE")
        except sqlite3.OperationalError as error:
            connection.close()
            if "locked" in str(error):
                raise RunFolderError(
                    f"{self.path} is in use by another run; wait for it, or choose another folder "
                    "with --out"
                ) from None
            raise RunFolderError(
                f"cannot write to {self.path} ({error}); choose another folder with --out"
            ) from None
        self._held = connection
