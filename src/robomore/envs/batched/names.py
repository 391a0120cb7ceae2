"""What a reward's names stand for while it runs for many simulations: `np`, `math`, `float`, …

NumPy asks its arguments how to be called, so most of its functions work on `Batched` as they are.
The rest (`np.array`, `max`, `math.exp`, …) insists on plain numbers and gets a stand-in.
"""

from __future__ import annotations

import builtins
import math
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from types import ModuleType
from typing import Any, cast

import numpy as np

from robomore.envs.batched.arrays import FUNCTIONS
from robomore.envs.batched.run import Run
from robomore.envs.batched.value import Batched, lift, stack

HARMLESS_MODULES = frozenset({"collections", "itertools", "functools", "operator", "typing"})
"""Modules of the standard library that keep nothing between calls."""

_FORBIDDEN = ("globals", "eval", "exec", "open", "input")

_MATH: Mapping[str, np.ufunc] = {
    "acos": np.arccos,
    "acosh": np.arccosh,
    "asin": np.arcsin,
    "asinh": np.arcsinh,
    "atan": np.arctan,
    "atan2": np.arctan2,
    "atanh": np.arctanh,
    "cos": np.cos,
    "cosh": np.cosh,
    "copysign": np.copysign,
    "degrees": np.degrees,
    "exp": np.exp,
    "expm1": np.expm1,
    "fabs": np.fabs,
    "fmod": np.fmod,
    "hypot": np.hypot,
    "isfinite": np.isfinite,
    "isinf": np.isinf,
    "isnan": np.isnan,
    "log": np.log,
    "log10": np.log10,
    "log1p": np.log1p,
    "log2": np.log2,
    "pow": np.power,
    "radians": np.radians,
    "sin": np.sin,
    "sinh": np.sinh,
    "sqrt": np.sqrt,
    "tan": np.tan,
    "tanh": np.tanh,
}
_WHOLE: Mapping[str, np.ufunc] = {"floor": np.floor, "ceil": np.ceil, "trunc": np.trunc}


class StandIns:
    """Stand-ins for the names of rewards that calculate with the `Batched` of one `Run`."""

    def __init__(self, run: Run) -> None:
        self._run = run
        self._modules: dict[str, Any] = {}
        as_float = partial(_as_float, run)
        self._float64 = _number_type(np.float64, as_float)
        self._math = {getattr(math, name): self._of_math(name) for name in (*_MATH, *_WHOLE)}
        self.builtins = vars(builtins) | {
            "float": _number_type(float, as_float),
            "int": _number_type(int, Batched.whole),
            "max": self._extreme(np.greater, max),
            "min": self._extreme(np.less, min),
            "isinstance": lambda value, kinds: isinstance(_sample(value), kinds),
            "__import__": self._import,
            **{name: self._forbidden(name) for name in _FORBIDDEN},
        }

    def module(self, module: ModuleType) -> Any:
        """Return what stands for `module`.

        Raises:
            Refused: what it does may not be the same when called once as when called often.
        """
        name = module.__name__
        top = name.partition(".")[0]
        if name == "numpy.random" or top not in {"numpy", "math", *HARMLESS_MODULES}:
            self._run.refuse(f"the module `{name}`")
        if top in HARMLESS_MODULES:
            return module
        if name not in self._modules:
            self._modules[name] = _Module(module, self.function)
        return self._modules[name]

    def function(self, value: Any) -> Any:
        """Return what stands for a member of NumPy, `math` or `builtins`."""
        if isinstance(value, ModuleType):
            return self.module(value)
        if isinstance(value, np.ufunc):
            return _Ufunc(value, self._run)
        if not callable(value):
            return value
        if value is np.float64:
            return self._float64
        if value in self._math:
            return self._math[value]
        name = getattr(value, "__name__", "")
        if getattr(value, "__module__", None) == "builtins":
            return self.builtins.get(name, value)
        if name in _CREATION and value is getattr(np, name):
            make = _CREATION[name]
            return lambda *args, **kwargs: make(self._run, *args, **kwargs)
        if isinstance(value, type) or getattr(value, "__module__", None) == "math":
            return value
        return _called(value, self._run)

    def _of_math(self, name: str) -> Callable[..., Any]:
        run, plain = self._run, getattr(math, name)
        ufunc = _MATH.get(name) or _WHOLE[name]

        def stand_in(*args: Any) -> Any:
            if not _mentioned(args):
                return plain(*args)
            numbers = [one.plain() if type(one) is Batched else one for one in args]
            if name == "log" and len(numbers) == 2:
                return Batched(np.log(numbers[0]) / np.log(numbers[1]), run)
            result = Batched(ufunc(*numbers), run)
            return result.whole() if name in _WHOLE else result

        return stand_in

    def _extreme(self, better: np.ufunc, plain: Callable[..., Any]) -> Callable[..., Any]:
        """Return `max` or `min`, which keep the first of equals."""
        run = self._run

        def stand_in(*args: Any, **kwargs: Any) -> Any:
            items = list(args[0]) if len(args) == 1 else list(args)
            if kwargs or not _mentioned(items):
                return plain(items, **kwargs) if len(items) > 1 else plain(*args, **kwargs)
            numbers = [one.plain() if type(one) is Batched else lift(one, run) for one in items]
            best = numbers[0]
            for number in numbers[1:]:
                best = np.where(better(number, best), number, best)
            return Batched(best, run)

        return stand_in

    def _forbidden(self, name: str) -> Callable[..., Any]:
        return lambda *args, **kwargs: self._run.refuse(f"`{name}`")

    def _import(
        self,
        name: str,
        globals: Any = None,
        locals: Any = None,
        fromlist: Sequence[str] = (),
        level: int = 0,
    ) -> Any:
        # Asked for before it is imported: importing may do anything.
        if name.partition(".")[0] not in {"numpy", "math", *HARMLESS_MODULES}:
            self._run.refuse(f"the module `{name}`")
        return self.module(builtins.__import__(name, globals, locals, fromlist, level))


class _Module:
    """A module whose members are stand-ins, made when first asked for."""

    def __init__(self, module: ModuleType, stand_in: Callable[[Any], Any]) -> None:
        vars(self).update(_module=module, _stand_in=stand_in)

    def __getattr__(self, name: str) -> Any:
        found = vars(self)[name] = self._stand_in(getattr(self._module, name))
        return found

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(name)


class _Ufunc:
    """A ufunc, with a short cut for one `Batched`."""

    def __init__(self, ufunc: np.ufunc, run: Run) -> None:
        self._ufunc = ufunc
        self._run = run
        self._simple = ufunc.nin == ufunc.nout == 1

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        if self._simple and len(args) == 1 and type(args[0]) is Batched and not kwargs:
            return Batched(self._ufunc(args[0].values), self._run)
        if _mentioned(args):
            return self._run.call(self._ufunc, args, kwargs)
        return self._ufunc(*args, **kwargs)

    def __getattr__(self, name: str) -> Any:
        member = getattr(self._ufunc, name)
        if not callable(member):
            return member
        if name == "at":
            self._run.refuse("`ufunc.at`")
        return _called(member, self._run)


def _called(function: Callable[..., Any], run: Run) -> Callable[..., Any]:
    """Return a function of NumPy's that takes `Batched` wherever it takes arrays."""
    known = FUNCTIONS.get(function)

    def stand_in(*args: Any, **kwargs: Any) -> Any:
        if known is not None and len(args) == 1 and type(args[0]) is Batched and not kwargs:
            result = known.function(run, args[0])
            return Batched(result, run) if type(result) is np.ndarray else result
        if _mentioned(args) or _mentioned(kwargs.values()):
            return run.call(function, args, kwargs)
        return function(*args, **kwargs)

    return stand_in


def _mentioned(values: Iterable[Any]) -> bool:
    """Whether any of `values`, or of the lists in them, differs between simulations."""
    return any(
        type(value) is Batched or (isinstance(value, (list, tuple, deque)) and _mentioned(value))
        for value in values
    )


def _sample(value: Any) -> Any:
    """Return something of the type that `value` has in each simulation."""
    if type(value) is not Batched:
        return value
    return np.empty(value.shape, value.dtype) if value.ndim else value.dtype.type(0)


def _number_type(kind: type, convert: Callable[[Batched], Batched]) -> type:
    """Return a stand-in for a type of numbers: a function, a type and a data type at once."""

    class Meta(type):
        def __instancecheck__(cls, value: object) -> bool:
            return isinstance(value, kind)

    class Number(kind, metaclass=Meta):  # type: ignore[misc]  # one of few classes
        dtype = np.dtype(kind)

        def __new__(cls, *args: Any, **kwargs: Any) -> Any:
            if len(args) == 1 and type(args[0]) is Batched:
                return convert(args[0])
            return kind(*args, **kwargs)

    return cast(type, Number)


def _as_float(run: Run, value: Batched) -> Batched:
    return Batched(value.plain() * 1.0, run)


def _array(run: Run, obj: Any, dtype: Any = None, copy: bool = True) -> Any:
    if type(obj) is Batched:
        array = obj.copy() if copy else obj
        return array if dtype is None else array.astype(dtype)
    if isinstance(obj, (list, tuple, deque)) and _mentioned(obj):
        array = Batched(stack(obj, run), run)
        return array if dtype is None else array.astype(dtype)
    plain = np.array(obj, dtype=dtype)
    return _own(run, plain) if plain.ndim and plain.dtype.kind == "f" else plain


def _own(run: Run, plain: Any) -> Batched:
    """Return an array that is the same in all simulations as one of their own, to be written to."""
    return Batched(np.repeat(plain[..., None], run.width, axis=-1), run)


def _filled(function: Callable[..., Any]) -> Callable[..., Any]:
    def make(run: Run, shape: Any, dtype: Any = float) -> Any:
        plain = function(shape, dtype=dtype)
        return _own(run, plain) if plain.ndim and plain.dtype.kind == "f" else plain

    return make


def _full(run: Run, shape: Any, fill_value: Any, dtype: Any = None) -> Any:
    if type(fill_value) is not Batched:
        return _array(run, np.full(shape, fill_value, dtype=dtype))
    own = _own(run, np.zeros(shape, dtype=dtype or float))
    own.values[...] = fill_value.values
    return own


def _as_array(run: Run, obj: Any, dtype: Any = None) -> Any:
    return obj if type(obj) is np.ndarray and dtype is None else _array(run, obj, dtype, copy=False)


_CREATION: Mapping[str, Callable[..., Any]] = {
    "array": _array,
    "asarray": _as_array,
    "asanyarray": _as_array,
    "ascontiguousarray": _as_array,
    "zeros": _filled(np.zeros),
    "ones": _filled(np.ones),
    "empty": _filled(np.zeros),
    "full": _full,
    "isscalar": lambda run, element: np.isscalar(_sample(element)),
}
"""By the name in NumPy."""
