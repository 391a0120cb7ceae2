"""NumPy's functions for many simulations at once; those not named here are called for each.

All take the run and then what NumPy's own take, and return `Values`.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from robomore.envs.batched.value import Batched, Values, lift, stack

if TYPE_CHECKING:
    from robomore.envs.batched.run import Run


_ADD: Any = np.add  # whose types do not know every way to call it


@dataclass(frozen=True, slots=True)
class Known:
    """How to call one function for all simulations.

    Attributes:
        function: takes the run, then what NumPy's function takes.
        most: positional arguments that it can do with.
        names: named arguments that it can do with.
    """

    function: Callable[..., Any]
    most: int
    names: Collection[str] = ()

    def takes(self, args: Sequence[Any], kwargs: Mapping[str, Any]) -> bool:
        """Whether a call is of the usual kind."""
        return len(args) <= self.most and all(name in self.names for name in kwargs)


def values_of(array: Any, run: Run) -> Values:
    """Return the values of an argument that is an array in each simulation."""
    if type(array) is Batched:
        return array.values
    plain = np.asarray(lift(array, run))
    return np.broadcast_to(plain, (*plain.shape[:-1], run.width))


def axes_of(axis: Any, values: Values) -> Any:
    """Return what `axis` of one simulation's array is in `values`, which end with simulations."""
    last = values.ndim - 1
    if axis is None:
        return 0 if last == 1 else tuple(range(last))
    if isinstance(axis, tuple):
        return tuple(one % last for one in axis)
    if not -last <= axis < last:
        raise np.exceptions.AxisError(axis, last)
    return int(axis) % last


def _reduction(ufunc: Any) -> Known:
    def reduce(run: Run, a: Any, axis: Any = None, keepdims: bool = False) -> Values:
        values = values_of(a, run)
        result: Values = ufunc.reduce(values, axis=axes_of(axis, values), keepdims=keepdims)
        return result

    return Known(reduce, 2, ("axis", "keepdims"))


def _along(function: Callable[..., Any], *names: str) -> Known:
    """Return how to call a function that takes `axis` as NumPy spells it."""

    def call(run: Run, a: Any, axis: Any = None, **named: Any) -> Values:
        values = values_of(a, run)
        result: Values = function(values, axis=axes_of(axis, values), **named)
        return result

    return Known(call, 2, ("axis", *names))


def _mean(run: Run, a: Any, axis: Any = None, keepdims: bool = False) -> Values:
    values = values_of(a, run)
    total = _ADD.reduce(values, axis=axes_of(axis, values), keepdims=keepdims)
    mean: Values = np.divide(total, values.size // max(total.size, 1))
    return mean


def _clip(
    run: Run, a: Any, a_min: Any = None, a_max: Any = None, min: Any = None, max: Any = None
) -> Values:
    values = values_of(a, run)
    low, high = (a_min if min is None else min), (a_max if max is None else max)
    # Several times faster than NumPy's own on small arrays.
    if low is not None:
        values = np.maximum(values, lift(low, run))
    return values if high is None else np.minimum(values, lift(high, run))


def _where(run: Run, condition: Any, x: Any, y: Any) -> Values:
    chosen: Values = np.where(lift(condition, run), lift(x, run), lift(y, run))
    return chosen


def _norm(run: Run, x: Any, ord: Any = None, axis: Any = None, keepdims: bool = False) -> Any:
    values = values_of(x, run)
    flat = values.ndim == 2 or (axis is None and ord is None) or isinstance(axis, int)
    if ord not in (None, 2) or not flat:
        return run.each(np.linalg.norm, (x,), {"ord": ord, "axis": axis, "keepdims": keepdims})
    squares = np.square(values)
    return np.sqrt(_ADD.reduce(squares, axis=axes_of(axis, values), keepdims=keepdims))


def _dot(run: Run, a: Any, b: Any) -> Any:
    one, other = lift(a, run), lift(b, run)
    dims = [np.ndim(one), np.ndim(other)]
    if min(dims) <= 1:
        return np.multiply(one, other)
    if dims == [2, 2] and one.shape[0] == other.shape[0]:
        return np.add.reduce(np.multiply(one, other), axis=0)
    return run.each(np.dot, (a, b), {})


def _matmul(run: Run, a: Any, b: Any) -> Any:
    if min(np.ndim(a), np.ndim(b)) == 0:
        raise ValueError("matmul: an operand has no dimension")
    return _dot(run, a, b) if np.ndim(a) == np.ndim(b) == 1 else run.each(np.matmul, (a, b), {})


def _difference(run: Run, a: Any, n: int = 1, axis: int = -1) -> Values:
    values = values_of(a, run)
    return np.diff(values, n, axis=axes_of(axis, values))


def _concatenate(run: Run, arrays: Sequence[Any], axis: int | None = 0) -> Values:
    parts = [values_of(array, run) for array in arrays]
    if axis is None:
        parts = [part.reshape(-1, run.width) for part in parts]
    if any(part.ndim == 1 for part in parts):
        raise ValueError("zero-dimensional arrays cannot be concatenated")
    return np.concatenate(parts, axis=axes_of(axis or 0, parts[0]))


def _hstack(run: Run, arrays: Sequence[Any]) -> Values:
    parts = [values_of(array, run) for array in arrays]
    parts = [part if part.ndim > 1 else part[None] for part in parts]
    return np.concatenate(parts, axis=0 if parts[0].ndim == 2 else 1)


def _stack(run: Run, arrays: Sequence[Any]) -> Values:
    return stack(arrays, run)


def _like(function: Callable[..., Any], extra: int = 0) -> Known:
    def make(run: Run, a: Any, *more: Any, **named: Any) -> Values:
        made: Values = function(values_of(a, run), *(lift(one, run) for one in more), **named)
        return made

    return Known(make, 1 + extra, ("dtype",))


def _round(run: Run, a: Any, decimals: int = 0) -> Values:
    return np.round(values_of(a, run), decimals)


def _nan_to_num(run: Run, x: Any) -> Values:
    return np.nan_to_num(values_of(x, run))


def _copy(run: Run, a: Any) -> Values:
    return values_of(a, run).copy()


def _ravel(run: Run, a: Any) -> Values:
    values = values_of(a, run)
    return values.reshape(-1, values.shape[-1])


def _shape(run: Run, a: Any) -> tuple[int, ...]:
    return values_of(a, run).shape[:-1]


def _ndim(run: Run, a: Any) -> int:
    return values_of(a, run).ndim - 1


FUNCTIONS: Mapping[Any, Known] = {
    np.sum: _reduction(np.add),
    np.prod: _reduction(np.multiply),
    np.max: _reduction(np.maximum),
    np.amax: _reduction(np.maximum),
    np.min: _reduction(np.minimum),
    np.amin: _reduction(np.minimum),
    np.any: _reduction(np.logical_or),
    np.all: _reduction(np.logical_and),
    np.mean: Known(_mean, 2, ("axis", "keepdims")),
    np.std: _along(np.std, "ddof", "keepdims"),
    np.var: _along(np.var, "ddof", "keepdims"),
    np.median: _along(np.median, "keepdims"),
    np.ptp: _along(np.ptp, "keepdims"),
    np.clip: Known(_clip, 3, ("a_min", "a_max", "min", "max")),
    np.where: Known(_where, 3),
    np.linalg.norm: Known(_norm, 3, ("ord", "axis", "keepdims")),
    np.dot: Known(_dot, 2),
    np.matmul: Known(_matmul, 2),
    np.diff: Known(_difference, 2, ("n", "axis")),
    np.concatenate: Known(_concatenate, 2, ("axis",)),
    np.stack: Known(_stack, 1),
    np.hstack: Known(_hstack, 1),
    np.zeros_like: _like(np.zeros_like),
    np.ones_like: _like(np.ones_like),
    np.empty_like: _like(np.zeros_like),
    np.full_like: _like(np.full_like, extra=1),
    np.round: Known(_round, 2, ("decimals",)),
    np.nan_to_num: Known(_nan_to_num, 1),
    np.copy: Known(_copy, 1),
    np.ravel: Known(_ravel, 1),
    np.shape: Known(_shape, 1),
    np.ndim: Known(_ndim, 1),
}
"""By NumPy's function."""

WRITING = frozenset({np.copyto, np.put, np.place, np.putmask, np.put_along_axis, np.fill_diagonal})
"""Functions that change their arguments."""
