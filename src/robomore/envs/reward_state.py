"""What a reward keeps in `self` between steps, as text for a checkpoint; never pickled."""

from __future__ import annotations

import base64
import json
from collections import deque
from typing import Any

import numpy as np


def dump(attributes: dict[str, Any]) -> bytes:
    """Return `attributes` as JSON from which `load` gives back equal values.

    Numbers, text, `None`, arrays, lists, tuples, sets, dicts and deques can be kept.

    Raises:
        TypeError: naming the attribute that holds something else.
    """
    encoded = {}
    for name, value in attributes.items():
        try:
            encoded[name] = _encode(value)
        except (TypeError, RecursionError) as error:
            raise TypeError(
                f"`self.{name}` cannot be kept in a checkpoint ({error}); use numbers, text, "
                "arrays, lists, tuples, sets, dicts or deques"
            ) from None
    return json.dumps(encoded).encode()


def load(text: bytes) -> dict[str, Any]:
    """Return what `dump` was given."""
    return {name: _decode(value) for name, value in json.loads(text).items()}


def _encode(value: Any) -> Any:
    # Exact types, so that a subclass never comes back as its base.
    kind = type(value)
    if value is None or kind in (bool, int, float, str):
        return value
    if kind is np.ndarray or isinstance(value, np.generic):
        array = np.asarray(value)
        if array.dtype.hasobject:
            raise TypeError("an array of Python objects")
        raw = base64.b64encode(array.tobytes()).decode()
        return {"array": [array.dtype.str, array.shape, raw, kind is not np.ndarray]}
    if kind is dict:
        return {"dict": [[_encode(key), _encode(item)] for key, item in value.items()]}
    if kind is deque:
        return {"deque": [[_encode(item) for item in value], value.maxlen]}
    if kind in (list, tuple, set):
        return {kind.__name__: [_encode(item) for item in value]}
    raise TypeError(f"it holds a {kind.__name__}")


def _decode(value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    ((kind, content),) = value.items()
    if kind == "array":
        dtype, shape, raw, scalar = content
        array = np.frombuffer(base64.b64decode(raw), dtype=dtype).reshape(shape).copy()
        return array[()] if scalar else array
    if kind == "dict":
        return {_decode(key): _decode(item) for key, item in content}
    if kind == "deque":
        return deque((_decode(item) for item in content[0]), maxlen=content[1])
    return {"list": list, "tuple": tuple, "set": set}[kind](_decode(item) for item in content)
