"""A folder that may come from somebody else: only plain files and folders in it are touched.

A link would lead out of the folder, and opening a pipe or a device may never end. So every name is
opened relative to the folder above it and without following links, and whatever is neither a plain
file nor a folder is refused. Only the folder's own path, which the user gave, may go through links.
"""

from __future__ import annotations

import os
import re
import secrets
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import mkdtemp
from typing import Literal

from robomore.errors import InputError, RunFolderError

_FOLDER = os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC
_MAKE = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC
_READ = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC

MOST_BYTES = 2**30
"""Longest file that is read at once."""


class NotPlainError(RunFolderError):
    """A name is taken by something else than a plain file or folder."""


def is_plain_name(name: str) -> bool:
    """Return whether `name` is one component of a path that leads nowhere else."""
    return name not in ("", os.curdir, os.pardir) and not {"/", "\0"} & set(name)


def read_plain(path: Path, most_bytes: int = MOST_BYTES) -> bytes:
    """Return the content of a plain file; see `PlainFolder.read`."""
    return PlainFolder(path.parent).read(path.name, most_bytes)


def write_plain(path: Path, content: bytes) -> None:
    """Write a file, whole or not at all; see `PlainFolder.write`."""
    PlainFolder(path.parent).write(path.name, content)


def cannot_write(path: Path, error: OSError, remedy: str) -> InputError:
    """Return what is said where `path` cannot be written: the reason and `remedy`."""
    if isinstance(error, FileNotFoundError) and not path.parent.is_dir():
        return InputError(
            f"cannot write {path}: there is no folder {path.parent}; make it, or {remedy}"
        )
    return InputError(f"cannot write {path} ({error.strerror or error}); {remedy}")


def what_stands_at(path: Path) -> str | None:
    """Return what a path, which may go through links, leads to: `a file`, `a folder`, `a named
    pipe`, …; `None` if there is nothing.
    """
    try:
        mode = path.stat().st_mode
    except (FileNotFoundError, NotADirectoryError, ValueError):  # of a name that no file can have
        return None
    except OSError as error:
        return f"out of reach ({error.strerror})"
    if stat.S_ISREG(mode) or stat.S_ISDIR(mode):
        return "a file" if stat.S_ISREG(mode) else "a folder"
    return next((words for test, words in _KINDS if test(mode)), "no plain file")


PARTIAL = re.compile(r"\..+-[0-9a-f]{8}\.partial")
"""Names of files that are being written, see `PlainFolder.write`."""


@contextmanager
def scratch_folder(above: Path, prefix: str) -> Iterator[Path]:
    """Make a new folder in `above` for untrusted code, and remove it whatever was left in it."""
    folder = Path(mkdtemp(prefix=prefix, dir=above))
    try:
        yield folder
    finally:
        PlainFolder(above).remove(folder.name)


class PlainFolder:
    """Reads, writes and removes below one folder. Names may have several parts, as in `a/b`."""

    def __init__(self, path: Path, follow: bool = True) -> None:
        """Stand for the folder at `path`, which need not exist yet.

        If not `follow`, the folder itself may be no link either.
        """
        self.path = path
        self._flags = _FOLDER if follow else _FOLDER | os.O_NOFOLLOW

    def kind(self, name: str) -> Literal["file", "folder"] | None:
        """Return what `name` is, `None` if there is nothing.

        Raises:
            NotPlainError: it is a link, a pipe, a socket or a device.
        """
        try:
            with self._parent(name) as (folder, last):
                mode = os.stat(last, dir_fd=folder, follow_symlinks=False).st_mode
        except (FileNotFoundError, NotADirectoryError):
            return None
        if stat.S_ISREG(mode):
            return "file"
        if stat.S_ISDIR(mode):
            return "folder"
        raise self._not_plain(name, mode)

    def is_file(self, name: str) -> bool:
        """Return whether there is a file of that name; a folder in its place is refused too.

        Raises:
            NotPlainError: something else has the name.
        """
        found = self.kind(name)
        if found == "folder":
            raise NotPlainError(f"{self.path / name} is a folder, no file; {_REMEDY}")
        return found == "file"

    def names(self, name: str = "") -> list[str]:
        """Return the names in a folder in order; none if it is missing."""
        try:
            with self._opened(name) as folder:
                return sorted(_entries(folder))
        except FileNotFoundError:
            return []

    def check(self, name: str = "", depth: int = 1) -> None:
        """Refuse a folder, or this one, in which something is not plain.

        Args:
            name: of the folder, which may be missing.
            depth: how many levels are looked at.

        Raises:
            NotPlainError: naming what is not.
        """
        for entry in self.names(name):
            inner = f"{name}/{entry}" if name else entry
            if self.kind(inner) == "folder" and depth > 1:
                self.check(inner, depth - 1)

    def read(self, name: str, most_bytes: int = MOST_BYTES) -> bytes:
        """Return the content of a file.

        Raises:
            NotPlainError: it is no plain file, or has more than `most_bytes`.
            OSError: it is missing, or cannot be read.
        """
        with self._parent(name) as (folder, last):
            try:
                descriptor = os.open(last, _READ, dir_fd=folder)
            except OSError:
                self.kind(name)  # raises where a link is the reason
                raise
        with os.fdopen(descriptor, "rb") as file:
            mode = os.fstat(descriptor).st_mode
            if not stat.S_ISREG(mode):
                raise self._not_plain(name, mode)
            content = file.read(most_bytes + 1)
        if len(content) > most_bytes:
            raise NotPlainError(f"{self.path / name} has more than {most_bytes:,} bytes")
        return content

    def write(self, name: str, content: bytes, to_disk: bool = False) -> None:
        """Write a file in the place of what had its name, whole or not at all.

        If `to_disk`, it is on the disk once this returns.

        Raises:
            NotPlainError: the name is taken by something that is no plain file.
            OSError: it cannot be written.
        """
        self.is_file(name)
        with self._parent(name) as (folder, last):
            partial = f".{last}-{secrets.token_hex(4)}.partial"
            descriptor = os.open(partial, _MAKE, 0o666, dir_fd=folder)
            try:
                with os.fdopen(descriptor, "wb") as file:
                    file.write(content)
                    if to_disk:
                        file.flush()
                        os.fsync(descriptor)
                os.replace(partial, last, src_dir_fd=folder, dst_dir_fd=folder)
            except BaseException:
                with suppress(OSError):
                    os.unlink(partial, dir_fd=folder)
                raise

    def make(self, name: str) -> None:
        """Make a folder, and the folders above it; one that is there stays.

        Raises:
            NotPlainError: the name is taken by something else.
            OSError: it cannot be made.
        """
        parts = name.split("/")
        for count in range(1, len(parts) + 1):
            inner = "/".join(parts[:count])
            with self._parent(inner) as (folder, last), suppress(FileExistsError):
                os.mkdir(last, dir_fd=folder)
            with self._opened(inner):
                pass

    def replace(self, old: str, new: str) -> None:
        """Give what is called `old` the name `new`, and remove what had that name.

        Raises:
            NotPlainError: a folder on the way is a link.
            OSError: it cannot be done.
        """
        self.remove(new)
        with self._parent(old) as (source, first), self._parent(new) as (target, last):
            os.replace(first, last, src_dir_fd=source, dst_dir_fd=target)

    def remove(self, name: str) -> None:
        """Remove a file, a link itself, or a folder with all that is in it; no link is followed.

        Raises:
            NotPlainError: a folder on the way is a link.
            OSError: it cannot be removed.
        """
        with suppress(FileNotFoundError), self._parent(name) as (folder, last):
            if not _unlinked(folder, last):
                with _entered(folder, last) as inner:
                    _empty(inner)
                os.rmdir(last, dir_fd=folder)

    @contextmanager
    def _parent(self, name: str) -> Iterator[tuple[int, str]]:
        """Give a descriptor of the folder that holds `name`, and the last part of the name."""
        above, _, last = name.rpartition("/")
        if not all(map(is_plain_name, name.split("/"))):
            raise NotPlainError(f"{name!r} is no name of a file in {self.path}; {_REMEDY}")
        with self._opened(above) as folder:
            yield folder, last

    @contextmanager
    def _opened(self, name: str) -> Iterator[int]:
        try:
            descriptor = os.open(self.path, self._flags)
        except OSError:
            if self._flags & os.O_NOFOLLOW and self.path.is_symlink():
                raise NotPlainError(f"{self.path} is a symbolic link; {_REMEDY}") from None
            raise
        try:
            for part in name.split("/") if name else ():
                try:
                    inner = os.open(part, _FOLDER | os.O_NOFOLLOW, dir_fd=descriptor)
                except OSError:
                    mode = os.stat(part, dir_fd=descriptor, follow_symlinks=False).st_mode
                    if not stat.S_ISDIR(mode):
                        raise self._not_plain(name, mode) from None
                    raise
                os.close(descriptor)
                descriptor = inner
            yield descriptor
        finally:
            os.close(descriptor)

    def _not_plain(self, name: str, mode: int) -> NotPlainError:
        said = next((words for test, words in _KINDS if test(mode)), "no plain file")
        return NotPlainError(f"{self.path / name} is {said}; {_REMEDY}")


def _empty(folder: int) -> None:
    """Remove all that is in a folder, however deep: untrusted code can nest without end.

    So folders within folders are moved up and not descended into.
    """
    while names := _entries(folder):
        for name in names:
            if _unlinked(folder, name):
                continue
            with _entered(folder, name) as inner:
                for entry in _entries(inner):
                    if not _unlinked(inner, entry):
                        moved = secrets.token_hex(16)
                        _make_usable(inner, entry)
                        os.rename(entry, moved, src_dir_fd=inner, dst_dir_fd=folder)
            os.rmdir(name, dir_fd=folder)


def _entries(folder: int) -> list[str]:
    with os.scandir(folder) as found:
        return [entry.name for entry in found]


def _unlinked(folder: int, name: str) -> bool:
    """Remove an entry and return `True`, unless it is a folder that may hold something."""
    if stat.S_ISDIR(os.stat(name, dir_fd=folder, follow_symlinks=False).st_mode):
        return False
    os.unlink(name, dir_fd=folder)
    return True


@contextmanager
def _entered(folder: int, name: str) -> Iterator[int]:
    _make_usable(folder, name)
    descriptor = os.open(name, _FOLDER | os.O_NOFOLLOW, dir_fd=folder)
    try:
        yield descriptor
    finally:
        os.close(descriptor)


def _make_usable(folder: int, name: str) -> None:
    """Let the owner list and change a folder, which may have been made without these rights."""
    facts = os.stat(name, dir_fd=folder, follow_symlinks=False)
    if facts.st_mode & stat.S_IRWXU == stat.S_IRWXU or facts.st_uid != os.geteuid():
        return
    if sys.platform == "linux":
        descriptor = os.open(name, os.O_PATH | _FOLDER | os.O_NOFOLLOW, dir_fd=folder)
        try:
            Path(f"/proc/self/fd/{descriptor}").chmod(0o700)
        finally:
            os.close(descriptor)
    else:
        os.chmod(name, 0o700, dir_fd=folder, follow_symlinks=False)


_KINDS = (
    (stat.S_ISLNK, "a symbolic link"),
    (stat.S_ISFIFO, "a named pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISREG, "a file where a folder is expected"),
)
_REMEDY = (
    "only plain files and folders are used, so that nothing leads out of the folder; move it away"
)
