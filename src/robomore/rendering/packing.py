"""JSON with arrays of numbers in it, as few bytes: what a page's replays and tables travel in.

A packed value is zlib data of `RMR1`, the length of the JSON text (4 bytes, little-endian), the
text, and the arrays one after the other, each at a multiple of 8 bytes. An array stands in the JSON
as `{"@": [offset, count, type]}`; `data.js` reads it back.
"""

from __future__ import annotations

import struct
import zlib
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from robomore.text import to_json

_TYPES = {"i1", "u1", "i2", "u2", "i4", "u4", "f4"}
_MAGIC = b"RMR1"


def pack(value: Any, level: int = 9) -> bytes:
    """Return `value` as bytes.

    Args:
        value: JSON data that may hold NumPy arrays of 1- to 4-byte numbers, which are flattened.
        level: of compression, 1 to 9.

    Raises:
        ValueError: an array of another type.
    """
    blob = bytearray()

    def without_arrays(one: Any) -> Any:
        match one:
            case np.ndarray():
                return {"@": _appended(blob, one)}
            case dict():
                return {key: without_arrays(item) for key, item in one.items()}
            case list() | tuple():
                return [without_arrays(item) for item in one]
        return one

    text = to_json(without_arrays(value))
    text += b" " * (-(len(text) + len(_MAGIC) + 4) % 8)
    return zlib.compress(_MAGIC + struct.pack("<I", len(text)) + text + bytes(blob), level)


def unpack(packed: bytes) -> Any:
    """Return what was packed, arrays flat."""
    data = zlib.decompress(packed)
    (length,) = struct.unpack_from("<I", data, len(_MAGIC))
    begin = len(_MAGIC) + 4
    body = data[begin + length :]

    def with_arrays(one: Any) -> Any:
        match one:
            case {"@": [offset, count, kind]}:
                return np.frombuffer(body, f"<{kind}", count, offset)
            case dict():
                return {key: with_arrays(item) for key, item in one.items()}
            case list():
                return [with_arrays(item) for item in one]
        return one

    return with_arrays(msgspec.json.decode(data[begin : begin + length]))


def changes(values: NDArray[Any], kind: str) -> NDArray[Any]:
    """Return an array's differences along its last axis, the first value first.

    They wrap around where `kind` is too small for them, as do the sums that undo them. Smooth
    motion gives small differences, which compress well.
    """
    whole = np.diff(np.asarray(values, np.int64), axis=-1, prepend=0)
    return whole.astype(f"<{kind}")


def _appended(blob: bytearray, array: NDArray[Any]) -> list[Any]:
    kind = array.dtype.str[1:]
    if kind not in _TYPES:
        raise ValueError(f"an array of {array.dtype} cannot be packed; use one of {sorted(_TYPES)}")
    blob.extend(b"\0" * (-len(blob) % 8))
    offset = len(blob)
    blob.extend(np.ascontiguousarray(array, f"<{kind}").tobytes())
    return [offset, array.size, kind]
