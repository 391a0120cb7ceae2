"""What a reward keeps in `self` between steps, for several simulations at once.

Numbers and arrays that may differ are `Batched`; lists, tuples, dicts and deques hold such values;
what is no `Batched` is the same in all simulations.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robomore.envs.batched.run import Run
from robomore.envs.batched.value import Batched

Rows = NDArray[np.intp]

Form = Any
"""What kinds of things a state is made of: states of one form can be joined."""


def form(value: Any, run: Run) -> Form:
    """Return the form of a kept value, made of tuples, text, whole numbers and `None`.

    Raises:
        Refused: it cannot be kept for several simulations.
    """
    kind = type(value)
    if kind is Batched:
        if not value.values.flags.writeable:
            run.refuse("a view of the simulation's arrays, kept until the next step")
        return ("array", *value.shape) if value.ndim else "number"
    if kind in (bool, int, float) or isinstance(value, np.generic):
        return "number"
    if kind is np.ndarray and not value.dtype.hasobject:
        return ("array", *value.shape) if value.ndim else "number"
    if value is None or kind is str:
        return ("constant", value)
    if kind in (list, tuple):
        return (kind.__name__, *(form(item, run) for item in value))
    if kind is deque:
        return ("deque", value.maxlen, *(form(item, run) for item in value))
    if kind is dict and all(type(key) in (str, int, bool) for key in value):
        return ("dict", *((key, form(item, run)) for key, item in value.items()))
    run.refuse(f"an object of type {kind.__name__}, kept until the next step")


def copied(value: Any) -> Any:
    """Return a copy that can be changed without changing `value`."""
    if isinstance(value, np.ndarray) or (type(value) is Batched and value.ndim):
        return value.copy()
    return _within(value, copied)


def selected(value: Any, positions: Rows) -> Any:
    """Return the part of a kept value that belongs to some of its simulations."""
    if type(value) is Batched:
        return Batched(value.values[..., positions], value.run)
    return value.copy() if isinstance(value, np.ndarray) else _within(value, selected, positions)


def single(value: Any, position: int) -> Any:
    """Return what a kept value is in one simulation."""
    if type(value) is Batched:
        part = value.values[..., position]
        if value.ndim:
            return part.copy()
        # A count that is kept is a whole number of Python's rather than one of NumPy's.
        return int(part) if part.dtype.kind == "i" else part[()]
    return value.copy() if isinstance(value, np.ndarray) else _within(value, single, position)


def joined(values: Sequence[Any], rows: Sequence[Rows], run: Run) -> Any:
    """Return values of one form as one value.

    Args:
        values: of each group of simulations.
        rows: the places of each group's simulations in the result.
        run: what the result is calculated with.
    """
    first = values[0]
    kind = type(first)
    if kind in (list, tuple, deque):
        items = [joined(items, rows, run) for items in zip(*values, strict=True)]
        return deque(items, first.maxlen) if kind is deque else kind(items)
    if kind is dict:
        return {key: joined([value[key] for value in values], rows, run) for key in first}
    if first is None or kind is str:
        return first
    if kind in (bool, int, float) and all(type(v) is kind and v == first for v in values[1:]):
        return first
    parts = [v.values if type(v) is Batched else np.asarray(v)[..., None] for v in values]
    width = sum(len(places) for places in rows)
    whole = np.empty((*parts[0].shape[:-1], width), np.result_type(*parts))
    for part, places in zip(parts, rows, strict=True):
        whole[..., places] = part
    return Batched(whole, run)


def same(value: Any, position: int, truth: Any, close: Callable[[Any, Any], bool]) -> bool:
    """Whether a kept value is `truth` in one simulation."""
    if isinstance(truth, (list, tuple, deque)):
        return (
            type(value) is type(truth)
            and len(value) == len(truth)
            and all(same(v, position, t, close) for v, t in zip(value, truth, strict=True))
        )
    if isinstance(truth, dict):
        return (
            isinstance(value, Mapping)
            and value.keys() == truth.keys()
            and all(same(value[key], position, truth[key], close) for key in truth)
        )
    own = single(value, position)
    if truth is None or isinstance(truth, str):
        return bool(own == truth)
    return isinstance(own, (int, float, np.generic, np.ndarray)) and close(own, truth)


def encoded(value: Any) -> Any:
    """Return a kept value without `Batched`, to be written down."""
    if type(value) is Batched:
        return ("batched", value.values)
    if isinstance(value, tuple):
        return ("tuple", *(encoded(item) for item in value))
    return _within(value, encoded)


def decoded(value: Any, run: Run) -> Any:
    """Return what `encoded` was given."""
    if isinstance(value, tuple):
        kind, *items = value
        if kind == "batched":
            return Batched(items[0], run)
        return tuple(decoded(item, run) for item in items)
    return _within(value, decoded, run)


def _within(value: Any, function: Callable[..., Any], *arguments: Any) -> Any:
    """Apply `function` to everything in a container; return anything else as it is."""
    kind = type(value)
    if kind in (list, tuple):
        return kind(function(item, *arguments) for item in value)
    if kind is deque:
        return deque((function(item, *arguments) for item in value), value.maxlen)
    if kind is dict:
        return {key: function(item, *arguments) for key, item in value.items()}
    return value
