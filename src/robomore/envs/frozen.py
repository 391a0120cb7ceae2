"""Copies of values that nobody can change."""

from __future__ import annotations

from collections.abc import Callable
from types import MappingProxyType
from typing import Any

import numpy as np


def frozen(value: Any, other: Callable[[Any], Any] = lambda value: value) -> Any:
    """Return arrays, dicts, lists and sets as something that cannot be changed.

    Args:
        value: to be copied, with all that it holds.
        other: is given what is none of these.
    """
    if isinstance(value, np.ndarray):
        return frozen_array(value)
    if isinstance(value, dict):
        return MappingProxyType({name: frozen(item, other) for name, item in value.items()})
    if isinstance(value, list | tuple):
        return tuple(frozen(item, other) for item in value)
    if isinstance(value, set):
        return frozenset(value)
    return other(value)


def frozen_array(array: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """Return a copy that cannot be made writable again, unlike one that owns its memory."""
    return np.frombuffer(array.tobytes(), array.dtype).reshape(array.shape)
