"""Reads files that a sandboxed process left in its folder, without trusting anything about them."""

from __future__ import annotations

import io
import os
import stat
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray


class UntrustedFileError(ValueError):
    """A file is not what a trusted program would have left; the message says in which way."""


def read_file(path: Path, most_bytes: int) -> bytes:
    """Return the content of a plain file.

    Args:
        path: in a folder that untrusted code could write to.
        most_bytes: largest size that is accepted.

    Raises:
        UntrustedFileError: it is missing, too long, or no plain file. (A link would lead out of
            the folder, and reading a named pipe would never end.)
    """
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    except OSError as error:
        raise UntrustedFileError(f"{path.name} cannot be read: {error.strerror}") from None
    facts = os.fstat(descriptor)
    if not stat.S_ISREG(facts.st_mode) or facts.st_nlink != 1:
        os.close(descriptor)
        raise UntrustedFileError(f"{path.name} is no plain file")
    with os.fdopen(descriptor, "rb") as file:
        content = file.read(most_bytes + 1)
    if len(content) > most_bytes:
        raise UntrustedFileError(f"{path.name} has more than {most_bytes:,} bytes")
    return content


def read_arrays(path: Path, most_bytes: int) -> dict[str, NDArray[Any]]:
    """Return the arrays of an `.npz` file; never unpickles and never inflates.

    Args:
        path: in a folder that untrusted code could write to.
        most_bytes: largest size that is accepted.

    Raises:
        UntrustedFileError: as `read_file` does, or it is no plain, uncompressed `.npz` of numbers.
    """
    content = io.BytesIO(read_file(path, most_bytes))
    try:
        with zipfile.ZipFile(content) as archive:
            members = archive.infolist()
            if any(it.compress_type != zipfile.ZIP_STORED for it in members):
                raise UntrustedFileError(f"{path.name} is compressed")
            if sum(it.file_size for it in members) > most_bytes:
                raise UntrustedFileError(f"{path.name} claims more than {most_bytes:,} bytes")
            # NumPy reads as many bytes as a header says, and a sum is looked at after the last.
            if (broken := archive.testzip()) is not None:
                raise UntrustedFileError(f"{path.name} is damaged in {broken!r}")
        content.seek(0)
        with np.load(content, allow_pickle=False) as arrays:
            return {name: arrays[name] for name in arrays.files}
    except UntrustedFileError:
        raise
    except _BROKEN as error:
        raise UntrustedFileError(f"{path.name} is no file of arrays: {error}") from None


_BROKEN = (
    *(ValueError, OSError, EOFError, KeyError, MemoryError, zipfile.BadZipFile),
    *(SyntaxError, RecursionError, RuntimeError),  # of headers and of encrypted members
)
