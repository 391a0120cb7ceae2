"""Reads files that a sandboxed process left in its folder, without trusting anything about them."""

from __future__ import annotations

import io
import math
import os
import re
import stat
import struct
import zipfile
from pathlib import Path

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


def read_arrays(path: Path, most_bytes: int, most_members: int) -> dict[str, NDArray[np.float32]]:
    """Return the arrays of an `.npz` file as NumPy writes it: float32 and nothing else.

    Args:
        path: in a folder that untrusted code could write to.
        most_bytes: largest size that is accepted.
        most_members: most arrays that are accepted.

    Raises:
        UntrustedFileError: as `read_file` does, or it is anything else. Nothing is unpickled,
            inflated, or believed that a header says of sizes.
    """
    return arrays_in(read_file(path, most_bytes), path.name, most_bytes, most_members)


def arrays_in(
    content: bytes, name: str, most_bytes: int, most_members: int
) -> dict[str, NDArray[np.float32]]:
    """Do what `read_arrays` does with the content of a file; errors call it `name`."""
    if len(content) > most_bytes:
        raise UntrustedFileError(f"{name} has more than {most_bytes:,} bytes")
    _check_list(name, content, most_members)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            members = archive.infolist()
            if len(members) > most_members or sum(it.file_size for it in members) > most_bytes:
                raise UntrustedFileError(f"{name} holds too many arrays, or too large ones")
            arrays = {}
            for member in members:
                member_name, _, ending = member.filename.rpartition(".")
                # Plain members alone: to inflate one, or to decrypt it, could take any time.
                stored = member.compress_type == zipfile.ZIP_STORED and not member.flag_bits & 1
                if ending != "npy" or member_name in arrays or not stored:
                    raise UntrustedFileError(f"{name} is not what NumPy writes")
                arrays[member_name] = _array(archive.read(member))
            return arrays
    except UntrustedFileError:
        raise
    except _BROKEN as error:
        raise UntrustedFileError(f"{name} is no file of arrays: {error}") from None


def _check_list(name: str, content: bytes, most_members: int) -> None:
    """Refuse an archive whose list of members is long, before `zipfile` reads all of the list.

    NumPy writes no comment, so that the end record is what an archive ends with, and a record of
    the larger form would stand before it.
    """
    end, larger = content[-_END.size :], content[-_END.size - 20 : -_END.size]
    if not end.startswith(b"PK\x05\x06") or len(end) < _END.size:
        raise UntrustedFileError(f"{name} is no file of arrays: no list of them ends it")
    if larger.startswith(b"PK\x06\x07"):
        raise UntrustedFileError(f"{name} is not what NumPy writes")
    members, list_bytes = _END.unpack(end)
    if members > most_members or list_bytes > _MOST_OF_A_MEMBER * most_members:
        raise UntrustedFileError(f"{name} holds too many arrays, or too large ones")


_END = struct.Struct("<10xHI6x")
"""The end record of an archive: how many members there are, and the size of their list in bytes."""
_MOST_OF_A_MEMBER = 512
"""Bytes that one member may take in the list."""


def _array(content: bytes) -> NDArray[np.float32]:
    """Return an array from the content of an `.npy` file.

    Its header is a Python expression. It is not parsed as one: NumPy writes it in one form alone.

    Raises:
        ValueError: it is anything but matrices and vectors of type float32 in C order.
    """
    head = _HEAD.match(content[:_LONGEST_HEAD])
    if head is None:
        said = content[:_LONGEST_HEAD].decode("latin-1").partition("{")[2].partition("}")[0]
        raise ValueError(f"its header {said!r} is none of a matrix or vector of float32")
    shape = tuple(int(number) for number in head[1].split(b",") if number.strip())
    numbers = np.frombuffer(content, np.float32, offset=head.end())
    if min(shape) < 1 or numbers.size != math.prod(shape):
        raise ValueError(f"it holds {numbers.size} numbers, which its shape {shape} does not fit")
    return numbers.reshape(shape).copy()


_LONGEST_HEAD = 256
_HEAD = re.compile(
    rb"\x93NUMPY\x01\x00..\{'descr': '<f4', 'fortran_order': False, "
    rb"'shape': \(([0-9]{1,9},|[0-9]{1,9}, [0-9]{1,9})\), \} *\n",
    re.DOTALL,
)
"""What NumPy writes at the beginning of a matrix or a vector: magic, version, length, header."""

_BROKEN = (
    *(ValueError, OSError, EOFError, KeyError, MemoryError, zipfile.BadZipFile),
    *(TypeError, RuntimeError, NotImplementedError, OverflowError),
)
"""What a damaged or manipulated archive can raise."""
