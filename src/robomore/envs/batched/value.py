"""One number or array of each simulation, held for all of them, that behaves as that of any one."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from robomore.envs.batched.run import Run

Values = NDArray[Any]
"""Numbers of m simulations, of shape (*shape, m): simulations are the last axis."""

Operator = Callable[["Batched", Any], "Batched"]


def lift(value: Any, run: Run) -> Any:
    """Return `value` so that NumPy broadcasts it against `Values`.

    Args:
        value: a `Batched`, or what is the same in all simulations: a number, an array, a list.
        run: refuses anything else.
    """
    kind = type(value)
    if kind is Batched:
        return value.values
    if kind is float or kind is int or isinstance(value, (bool, np.generic)):
        return value
    if isinstance(value, (list, tuple, deque)):
        return stack(value, run)
    if kind is np.ndarray and not value.dtype.hasobject:
        return value[..., None] if value.ndim else value
    run.refuse(f"a calculation with an object of type {kind.__name__}")


def stack(items: Iterable[Any], run: Run) -> Values:
    """Return the values of `np.array(items)`, where numbers may differ between simulations."""
    rows = [
        np.broadcast_to(row, (*row.shape[:-1], run.width) if row.ndim else (run.width,))
        for row in (np.asarray(lift(item, run)) for item in items)
    ]
    return np.stack(rows) if rows else np.zeros((0, run.width))


def _operators(ufunc: Any) -> tuple[Operator, Operator, Operator]:
    """Return `a + b`, `b + a` and `a += b` for one operation."""

    def forward(self: Batched, other: Any) -> Batched:
        kind = type(other)
        if kind is Batched:
            other = other.values
        elif kind is not float and kind is not int:
            other = lift(other, self.run)
        return Batched(ufunc(self.values, other), self.run)

    def backward(self: Batched, other: Any) -> Batched:
        if type(other) is not float:
            other = lift(other, self.run)
        return Batched(ufunc(other, self.values), self.run)

    def in_place(self: Batched, other: Any) -> Batched:
        if self.values.ndim == 1:  # a number: the name is bound to a new one
            return forward(self, other)
        ufunc(self.values, lift(other, self.run), out=self.values)
        return self

    return forward, backward, in_place


class Batched:
    """A value of m simulations at once, which behaves as the NumPy scalar or array of any of them.

    With simulations as the last axis, NumPy's own broadcasting and indexing do what they would do
    in each simulation. What cannot be done for all at once is refused (`Run.refuse`), and a
    condition that holds in some simulations only ends the run (`Run.decide`).

    Attributes:
        values: (*shape, m).
        run: the run of the reward that this is part of.
    """

    __slots__ = ("run", "values")
    __hash__: ClassVar[None] = None  # type: ignore[assignment]  # as arrays

    def __init__(self, values: Values, run: Run) -> None:
        self.values = values
        self.run = run

    __add__, __radd__, __iadd__ = _operators(np.add)
    __sub__, __rsub__, __isub__ = _operators(np.subtract)
    __mul__, __rmul__, __imul__ = _operators(np.multiply)
    __truediv__, __rtruediv__, __itruediv__ = _operators(np.divide)
    __floordiv__, __rfloordiv__, __ifloordiv__ = _operators(np.floor_divide)
    __mod__, __rmod__, __imod__ = _operators(np.remainder)
    __pow__, __rpow__, __ipow__ = _operators(np.power)
    __and__, __rand__, __iand__ = _operators(np.bitwise_and)
    __or__, __ror__, __ior__ = _operators(np.bitwise_or)
    __xor__, __rxor__, __ixor__ = _operators(np.bitwise_xor)
    __lt__, __gt__ = _operators(np.less)[0], _operators(np.greater)[0]
    __le__, __ge__ = _operators(np.less_equal)[0], _operators(np.greater_equal)[0]
    __eq__: Any = _operators(np.equal)[0]
    __ne__: Any = _operators(np.not_equal)[0]

    def __neg__(self) -> Batched:
        return Batched(np.negative(self.values), self.run)

    def __pos__(self) -> Batched:
        return Batched(np.positive(self.values), self.run)

    def __abs__(self) -> Batched:
        return Batched(np.absolute(self.values), self.run)

    def __invert__(self) -> Batched:
        return Batched(np.invert(self.values), self.run)

    def __matmul__(self, other: Any) -> Any:
        return self.run.call(np.matmul, (self, other), {})

    def __rmatmul__(self, other: Any) -> Any:
        return self.run.call(np.matmul, (other, self), {})

    def __round__(self, digits: int | None = None) -> Batched:
        rounded = Batched(np.round(self.values, digits or 0), self.run)
        return rounded.whole() if digits is None else rounded

    def __divmod__(self, other: Any) -> tuple[Batched, Batched]:
        return self // other, self % other

    def __rdivmod__(self, other: Any) -> tuple[Batched, Batched]:
        return other // self, other % self

    def __bool__(self) -> bool:
        return self.run.decide(self.number())

    def __len__(self) -> int:
        if self.values.ndim == 1:
            raise TypeError("a number has no len()")
        return len(self.values)

    def __iter__(self) -> Iterator[Batched]:
        return (self[i] for i in range(len(self)))

    def __getitem__(self, key: Any) -> Batched:
        part = self.values[self._index(key)]
        # A number that was read stays what it was, whatever becomes of the array.
        return Batched(part.copy() if part.ndim == 1 else part, self.run)

    def __setitem__(self, key: Any, value: Any) -> None:
        if self.values.ndim == 1:
            raise TypeError("a number does not support item assignment")
        if type(key) is Batched and key.dtype == np.bool_ and key.shape == self.shape:
            np.copyto(self.values, lift(value, self.run), where=key.values)
        else:
            self.values[self._index(key)] = lift(value, self.run)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        if method == "at":
            self.run.refuse("`ufunc.at`")
        function = ufunc if method == "__call__" else getattr(ufunc, method)
        return self.run.call(function, inputs, kwargs)

    def __array_function__(
        self, function: Any, types: Any, args: Sequence[Any], kwargs: Mapping[str, Any]
    ) -> Any:
        return self.run.call(function, args, kwargs)

    def __array__(self, *arguments: Any, **named: Any) -> Any:
        self.run.refuse("a function that wants a plain array")

    def __float__(self) -> float:
        self.run.refuse("a function that wants a plain number")

    def __int__(self) -> int:
        self.run.refuse("a function that wants a plain number")

    def __index__(self) -> int:
        self.run.refuse("an index that differs between simulations")

    def __str__(self) -> str:
        self.run.refuse("a number as text")

    def __format__(self, spec: str) -> str:
        self.run.refuse("a number as text")

    def __copy__(self) -> Batched:
        return self.copy()

    def __deepcopy__(self, memo: Any) -> Batched:
        return self.copy()

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)  # copying and NumPy ask for what need not be there
        if name in _METHODS:
            function = _METHODS[name]
            return lambda *args, **kwargs: self.run.call(function, (self, *args), kwargs)
        self.run.refuse(f"`.{name}` of a number or array")

    @property
    def shape(self) -> tuple[int, ...]:
        return self.values.shape[:-1]

    @property
    def ndim(self) -> int:
        return self.values.ndim - 1

    @property
    def size(self) -> int:
        return math.prod(self.shape)

    @property
    def dtype(self) -> np.dtype[Any]:
        return self.values.dtype

    @property
    def T(self) -> Batched:  # noqa: N802  # as NumPy spells it
        *axes, last = range(self.values.ndim)
        return Batched(self.values.transpose(*reversed(axes), last), self.run)

    @property
    def flat(self) -> Batched:
        return self.reshape(-1)

    def reshape(self, *shape: Any, order: str = "C") -> Batched:
        wanted = tuple(shape[0]) if len(shape) == 1 and isinstance(shape[0], tuple) else shape
        if order != "C":
            self.run.refuse("an array in another order")
        if self.values.ndim == 2 and wanted == (-1,):
            return Batched(self.values[:], self.run)
        shaped = self.values.reshape(*wanted, self.values.shape[-1])
        return Batched(shaped if wanted else shaped.copy(), self.run)

    def ravel(self) -> Batched:
        return self.reshape(-1)

    def flatten(self) -> Batched:
        return self.reshape(-1).copy()

    def copy(self, *order: str) -> Batched:
        return Batched(self.values.copy(), self.run)

    def astype(self, dtype: Any, copy: bool = True) -> Batched:
        return Batched(self.values.astype(dtype), self.run)

    def item(self, *index: int) -> Batched:
        return self[index].item() if index else Batched(self.number().copy(), self.run)

    def tolist(self) -> Any:
        return [part.tolist() for part in self] if self.ndim else self

    def plain(self) -> Values:
        """Return (m,): the number that this is in each simulation, where no array will do."""
        if self.values.ndim > 1:
            self.run.refuse("an array in the place of a number")
        return self.values

    def number(self) -> Values:
        """Return (m,): the one number that this holds in each simulation."""
        if self.values.ndim == 1:
            return self.values
        if self.size != 1:
            self.run.refuse("an array in the place of a number")
        return self.values.reshape(-1)

    def whole(self) -> Batched:
        """Return the number without its fraction, as `int` does."""
        number = np.trunc(self.plain() * 1.0)
        if not np.isfinite(number).all():
            self.run.refuse("`int` of what is not finite")
        return Batched(number.astype(np.int64), self.run)

    def _index(self, key: Any) -> Any:
        """Return `key` as an index into `values`, which never reaches the axis of simulations."""
        room = self.values.ndim - 1
        if type(key) is int or type(key) is slice:
            if not room:
                raise IndexError("invalid index to scalar variable.")
            return key
        parts = list(key) if isinstance(key, tuple) else [key]
        for i, part in enumerate(parts):
            if part is None or part is Ellipsis:
                continue
            if isinstance(part, (list, np.ndarray)):
                parts[i] = part = np.asarray(part)
                room -= part.ndim if part.dtype == np.bool_ else 1
            elif isinstance(part, (int, np.integer, slice)) and not isinstance(part, bool):
                room -= 1
            else:
                self.run.refuse("an index that differs between simulations")
        if room < 0:
            raise IndexError("too many indices for array")
        open_ended = any(part is Ellipsis for part in parts)
        return (*parts, slice(None)) if open_ended else tuple(parts)


_METHODS: Mapping[str, Callable[..., Any]] = {
    "all": np.all,
    "any": np.any,
    "argmax": np.argmax,
    "argmin": np.argmin,
    "clip": np.clip,
    "cumsum": np.cumsum,
    "dot": np.dot,
    "max": np.max,
    "mean": np.mean,
    "min": np.min,
    "prod": np.prod,
    "round": np.round,
    "squeeze": np.squeeze,
    "std": np.std,
    "sum": np.sum,
    "var": np.var,
}
"""Methods of arrays that NumPy has as functions, too."""
