"""Folders that jobs hand on to later jobs, as one row of bytes: they travel between machines.

Untrusted code may have written what is in such a folder. Nothing of it is read here but names and
sizes, and only plain files are made of it again.
"""

from __future__ import annotations

import os
import stat
import tempfile
from contextlib import suppress
from pathlib import Path

import msgspec

from robomore.errors import UnfitWorker
from robomore.plain_files import PlainFolder, is_plain_name

_MOST_BYTES = 2 * 2**30
"""Of a folder that is carried; a larger one stays behind."""
_MOST_FILES = 16
_OTHERS = stat.S_IRWXG | stat.S_IRWXO
"""Rights of anybody but the owner."""


def carried_folder(name: str, above: Path | None = None) -> Path:
    """Return where a job finds the folder that is carried to it under that name.

    It lies in a folder that nobody but this user can write to, which is made if it is missing: on a
    machine that many people share, anybody can put something of that name into `/tmp` before.

    Args:
        name: one component of a path.
        above: folder for temporary files of whoever runs the job; the usual one by default.

    Raises:
        UnfitWorker: that folder is somebody else's, a link, or open to others.
        ValueError: the name is no plain one.
    """
    if not is_plain_name(name):
        raise ValueError(f"{name!r} is no name of a carried folder")
    user = os.geteuid()
    folder = (above or Path(tempfile.gettempdir())) / f"robomore-carried-{user}"
    try:
        with suppress(FileExistsError):
            folder.mkdir(mode=0o700)
        facts = folder.lstat()
    except OSError as error:
        raise UnfitWorker(
            f"{folder} cannot be made ({error.strerror}); set TMPDIR to a folder of your own"
        ) from None
    if not stat.S_ISDIR(facts.st_mode) or facts.st_uid != user or facts.st_mode & _OTHERS:
        raise UnfitWorker(
            f"{folder} is no folder that only you can use, so others could change what a job "
            "continues from; remove it, or set TMPDIR to a folder of your own"
        )
    return folder / name


def packed(folder: Path) -> bytes | None:
    """Return the files of `folder` as bytes; `None` if there are none, or too much to carry.

    Untrusted code may have left a name there that no checkpoint has; then nothing is carried.

    Raises:
        OSError: something in it cannot be read.
        RunFolderError: something in it is not a plain file.
    """
    files = PlainFolder(folder, follow=False)
    names = files.names()
    named = all(name.isascii() for name in names)
    if not names or len(names) > _MOST_FILES or not named:
        return None
    contents, left = [], _MOST_BYTES
    for name in names:
        contents.append(files.read(name, left))
        left -= len(contents[-1])
    head = msgspec.json.encode([(n, len(c)) for n, c in zip(names, contents, strict=True)])
    return b"\n".join([head, b"".join(contents)])


def unpack(content: bytes, folder: Path) -> None:
    """Make the files in `folder` that `packed` was given.

    Raises:
        ValueError: these bytes do not come from `packed`.
    """
    end = content.index(b"\n")
    listed = msgspec.json.decode(content[:end], type=list[tuple[str, int]])
    if len(listed) > _MOST_FILES or not all(is_plain_name(n) and size >= 0 for n, size in listed):
        raise ValueError("names that are no plain names, or too many of them")
    if end + 1 + sum(size for _, size in listed) != len(content):
        raise ValueError("the sizes do not add up")
    with suppress(FileExistsError):
        folder.mkdir(mode=0o700)
    files = PlainFolder(folder, follow=False)
    begin = end + 1
    for name, size in listed:
        files.write(name, content[begin : begin + size])
        begin += size
