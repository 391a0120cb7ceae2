"""The same program with other names: a reward whose `np`, `math`, `float`, … know batches."""

from __future__ import annotations

import dis
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import (
    BuiltinFunctionType,
    CellType,
    CodeType,
    FunctionType,
    MappingProxyType,
    ModuleType,
)
from typing import Any

import numpy as np

from robomore.envs.batched.names import HARMLESS_MODULES, StandIns
from robomore.envs.batched.run import Run

_CONSTANTS = (bool, int, float, complex, str, bytes, range, type(None), type(...), np.generic)
_CODE = (type, FunctionType, BuiltinFunctionType, type(np.sum))
_KEEPING = frozenset({"setattr", "delattr", "vars", "__dict__", "__setattr__", "__delattr__"})
_PLAIN = frozenset({"float", "int", "round", "item", "tolist", "math"})
_SHARING = frozenset({"STORE_GLOBAL", "DELETE_GLOBAL"})
_SETTING = frozenset({"STORE_ATTR", "DELETE_ATTR"})


@dataclass(frozen=True, slots=True)
class BatchedFunction:
    """A reward that can be called on `Batched` values.

    Attributes:
        call: `_get_rew(self, x_velocity, action)`.
        stand_ins: of the names that it uses.
        keeps: whether it may keep anything in `self`.
        plain: whether it may use plain numbers of Python.
    """

    call: Callable[[Any, Any, Any], Any]
    stand_ins: StandIns
    keeps: bool
    plain: bool


def batched_function(reward: Callable[..., Any], run: Run) -> BatchedFunction:
    """Return `reward` as a function that calculates with the `Batched` values of `run`.

    The code is the same; it runs in a namespace of its own in which some names have stand-ins.

    Raises:
        Refused: it is not a plain function, or shares something that may change between calls.
    """
    wrappers = []
    while hasattr(reward, "__wrapped__"):
        wrappers.append(reward)
        reward = reward.__wrapped__
    if not isinstance(reward, FunctionType):
        run.refuse("something else than a function")
    namespace = _Namespace(reward, run)
    call: Any = namespace.rebound(reward)
    for wrapper in reversed(wrappers):
        call = _rewrapped(wrapper, call, run)
    return BatchedFunction(call, namespace.stand_ins, namespace.keeps, namespace.plain)


class _Namespace:
    """The globals of a reward, with stand-ins, and without anything that can be changed."""

    def __init__(self, reward: FunctionType, run: Run) -> None:
        self._run = run
        self._original = reward.__globals__
        self.stand_ins = StandIns(run)
        self._globals: dict[str, Any] = {"__builtins__": self.stand_ins.builtins}
        self.keeps = False
        self.plain = False

    def rebound(self, function: FunctionType) -> FunctionType:
        """Return `function` in this namespace, which gets what it refers to."""
        if function.__closure__:
            self._run.refuse("variables of a function around it")
        names: set[str] = set()
        for code in _codes(function.__code__):
            for instruction in dis.get_instructions(code):
                if instruction.opname in _SHARING:
                    self._run.refuse(f"the global variable `{instruction.argval}`, which it sets")
                self.keeps |= instruction.opname in _SETTING
            names.update(code.co_names)
        self.keeps |= not _KEEPING.isdisjoint(names)
        self.plain |= not _PLAIN.isdisjoint(names)
        rebound = FunctionType(
            function.__code__,
            self._globals,
            function.__name__,
            tuple(self._frozen("a default", value) for value in function.__defaults__ or ()),
        )
        rebound.__kwdefaults__ = {
            name: self._frozen(name, value)
            for name, value in (function.__kwdefaults__ or {}).items()
        }
        for name in sorted(names & self._original.keys()):
            if name not in self._globals:
                self._globals[name] = None  # functions may call each other
                self._globals[name] = self._frozen(name, self._original[name])
        return rebound

    def _frozen(self, name: str, value: Any) -> Any:
        """Return what stands for a global, so that calling once or often makes no difference."""
        if isinstance(value, _CONSTANTS):
            return value
        if isinstance(value, (tuple, list)):
            return tuple(self._frozen(name, item) for item in value)
        if isinstance(value, (set, frozenset)):
            return frozenset(value)
        if isinstance(value, dict):
            return MappingProxyType({k: self._frozen(name, v) for k, v in value.items()})
        if isinstance(value, np.ndarray) and not value.dtype.hasobject:
            copy = value.copy()
            copy.flags.writeable = False
            return copy
        if isinstance(value, FunctionType) and value.__globals__ is self._original:
            # A method of the function: unlike the function itself, it has no attributes to set.
            return self.rebound(value).__call__
        if isinstance(value, (ModuleType, np.ufunc)):
            return self.stand_ins.function(value)
        module = getattr(value, "__module__", None) or ""
        home = module.partition(".")[0]
        self.plain |= home == "math"
        if isinstance(value, _CODE) and not module.startswith("numpy.random"):
            if home in ("builtins", "math", "numpy"):
                return self.stand_ins.function(value)
            if home in HARMLESS_MODULES or isinstance(value, FunctionType):
                return value
        kind = "a class" if isinstance(value, type) else f"a {type(value).__name__}"
        self._run.refuse(f"`{name}`, {kind}")


def _codes(code: CodeType) -> Iterator[CodeType]:
    """Yield `code` and that of the functions inside it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)


def _rewrapped(wrapper: Any, function: Any, run: Run) -> Any:
    """Return what `wrapper` makes of `function` instead of the function that it wraps now.

    Only the project's own wrapper is known well enough: the one that counts calls.
    """
    if not isinstance(wrapper, FunctionType) or not wrapper.__module__.startswith("robomore."):
        run.refuse("a decorator")
    inner = wrapper.__wrapped__  # type: ignore[attr-defined]  # that is how it was found
    cells = tuple(
        CellType(function) if cell.cell_contents is inner else cell
        for cell in wrapper.__closure__ or ()
    )
    return FunctionType(
        wrapper.__code__, wrapper.__globals__, wrapper.__name__, wrapper.__defaults__, cells
    )
