"""What a reward keeps between steps, as text for a checkpoint; never pickled.

That is what lies in `self`, and what the objects of the reward's own module hold: lists at the top
level, default arguments, closures, attributes of functions, classes and helper objects. Objects
that several names share are written once, so they are shared again afterwards.
"""

from __future__ import annotations

import base64
import enum
import functools
import json
import math
import types
from collections import defaultdict, deque
from collections.abc import Mapping
from typing import Any

import numpy as np

from robomore.envs.random_state import has_spawned
from robomore.envs.reward_objects import (
    ATOMS,
    FixedObjects,
    address,
    attributes,
    cell_content,
    check_class,
    class_attributes,
    is_constant,
    is_own_class,
    is_own_function,
    native,
    slots,
)
from robomore.envs.reward_program import RewardInstance

_PLAIN_INT = 2**53
_DEEPEST = 100
"""Objects inside each other; far from what the interpreter can follow when they are read again."""
_GENERATORS = ("PCG64", "PCG64DXSM", "MT19937", "Philox", "SFC64")


NANS = {"math": math.nan, "numpy": np.nan}
"""The one that a module calls `nan`."""


class UnsavedStateError(TypeError):
    """A reward keeps something that cannot be written down.

    Attributes:
        name: at the top level of the reward, or of the attribute of `self`.
    """

    def __init__(self, name: str, message: str) -> None:
        """Say what is kept where."""
        super().__init__(message)
        self.name = name


def dump(
    instance: RewardInstance | None,
    fixed: FixedObjects,
    kept: Mapping[str, Any],
    known: Mapping[str, Any],
) -> bytes:
    """Return the state of one simulation's reward as JSON, from which `load` restores it.

    Args:
        instance: the reward of this simulation; `None` for a function that has no text.
        fixed: made when `instance` was new.
        kept: attributes that the reward keeps in `self`.
        known: objects of the simulation by name, `self` among them: named, not written down.

    Raises:
        UnsavedStateError: naming what cannot be kept.
    """
    writer = _Writer(instance, fixed, known)
    state: dict[str, Any] = {"self": {}, "module": {}, "fixed": []}
    for name in sorted(kept):
        state["self"][name] = writer.root(name, f"self.{name}", kept[name])
    if instance is not None:
        for name, value in instance.names().items():
            state["module"][name] = writer.root(name, name, value)
        state["fixed"] = [writer.fixed_state(value) for value in fixed.values]
    state["nodes"] = writer.nodes
    return json.dumps(state).encode()


class _Writer:
    """Writes values: atoms as they are, everything else as `[kind, …]`."""

    def __init__(
        self, instance: RewardInstance | None, fixed: FixedObjects, known: Mapping[str, Any]
    ) -> None:
        self.nodes: list[Any] = []
        self._instance = instance
        self._fixed = fixed
        self._known = {id(value): name for name, value in known.items()}
        self._written: dict[int, int] = {}
        self._alive: list[Any] = []  # what was written, so that no identity is used twice
        self._open: set[int] = set()
        self._depth = 0

    def root(self, name: str, shown: str, value: Any) -> Any:
        """Write what a name stands for.

        Raises:
            UnsavedStateError: it cannot be written.
        """
        try:
            return self.value(value)
        except TypeError as error:
            said = str(error)
        raise UnsavedStateError(
            name,
            f"`{shown}` cannot be kept in a checkpoint ({said}); keep numbers, text, arrays, "
            "lists, tuples, dicts, deques, or objects of your own classes that hold them",
        ) from None

    def fixed_state(self, value: Any) -> Any:
        """Write what a fixed object refers to, `None` if it never changes."""
        if isinstance(value, types.FunctionType):
            if self._instance is None or not is_own_function(value, self._instance):
                return None
            name = value.__name__
            parts = (value.__defaults__, value.__kwdefaults__, vars(value))
            return [self.root(name, name, part) for part in parts]
        if isinstance(value, types.CellType):
            return [self.root("", "a closure", one) for one in cell_content(value)]
        if isinstance(value, enum.Enum):
            inner = {k: v for k, v in vars(value).items() if k != "__objclass__"}
            return self.root(value.name, f"{type(value).__name__}.{value.name}", inner)
        if is_own_class(value):
            for field in vars(value).get("__dataclass_fields__", {}).values():
                if not is_constant(field.metadata):
                    raise UnsavedStateError(
                        value.__name__,
                        f"`{value.__name__}.{field.name}` has metadata that can change; keep it in "
                        "an attribute",
                    )
            return {
                name: self.root(name, f"{value.__name__}.{name}", one)
                for name, one in class_attributes(value).items()
            }
        return None

    def value(self, value: Any) -> Any:
        """Write a value.

        Raises:
            TypeError: saying why it cannot be written.
        """
        kind = type(value)
        if kind is int and abs(value) >= _PLAIN_INT:
            return ["int", hex(value)]
        # One NaN equals itself in a list, and differs from every other: it is an object of its own.
        if kind in ATOMS and not _is_nan(value):
            return value
        place = self._fixed.place(value)
        if place is not None:
            return ["fixed", place]
        if id(value) in self._known:
            return ["known", self._known[id(value)]]
        if id(value) in self._written:
            return ["node", self._written[id(value)]]
        if _is_nan(value):
            return self._node(value)
        if isinstance(value, np.generic) and not is_own_class(kind):
            array = np.asarray(value)
            return ["scalar", *_memory(array)]
        if isinstance(value, np.dtype):
            return ["dtype", _dtype(value)]
        if kind is complex or value is Ellipsis or value is NotImplemented:
            return ["constant", repr(value)]
        found = address(value)
        if found is not None:
            return ["address", found]
        if id(value) in self._open:
            raise TypeError("it holds a tuple that holds itself")
        return self._node(value)

    def _node(self, value: Any) -> list[Any]:
        self._alive.append(value)
        changes = not isinstance(value, tuple | functools.partial | types.MethodType)
        place = len(self.nodes)
        self.nodes.append(None)
        if changes:
            self._written[id(value)] = place
        else:
            self._open.add(id(value))
        self._depth += 1
        if self._depth > _DEEPEST:
            raise TypeError("it is nested too deeply")
        self.nodes[place] = self._content(value)
        self._depth -= 1
        self._open.discard(id(value))
        self._written[id(value)] = place
        return ["node", place]

    def _content(self, value: Any) -> list[Any]:
        kind, write = type(value), self.value
        if _is_nan(value):
            module = next((name for name, one in NANS.items() if one is value), "")
            return ["nan", module, isinstance(value, np.generic), *_memory(np.asarray(value))]
        if kind is np.ndarray:
            return self._array(value)
        if kind is types.CellType:
            return ["cell", [write(one) for one in cell_content(value)]]
        if kind is types.FunctionType:
            return self._function(value)
        if kind is types.MethodType:
            return ["method", write(value.__func__), write(value.__self__)]
        if kind is types.BuiltinFunctionType:
            return ["builtin", write(value.__self__), value.__name__]
        if kind is functools.partial:
            if vars(value):
                raise TypeError("it holds a `partial` with attributes of its own")
            return ["partial", write(value.func), write(value.args), write(value.keywords)]
        if kind is slice or kind is range:
            parts = (value.start, value.stop, value.step)
            return [kind.__name__, [write(part) for part in parts]]
        if kind is np.random.Generator:
            return self._generator(value)
        if isinstance(value, type):
            raise TypeError("it holds a class that was made during a call")
        return self._object(value)

    def _object(self, value: Any) -> list[Any]:
        kind = type(value)
        check_class(kind)
        base: Any = native(value)
        content: Any = None
        if base is not None and issubclass(base, dict):
            content = [[self.value(k), self.value(v)] for k, v in base.items(value)]
        elif base in (list, tuple, deque):
            content = [self.value(one) for one in base.__iter__(value)]
        elif base in (bytes, bytearray):
            content = base64.b64encode(bytes(value)).decode()
        elif base is not None:
            content = self.value(base(value))
        extra = None
        if isinstance(value, deque):
            extra = value.maxlen
        elif isinstance(value, defaultdict):
            extra = self.value(value.default_factory)
        inner = attributes(value)
        return [
            "object",
            self.value(kind),
            base.__name__ if base else "",
            content,
            extra,
            {name: self.value(one) for name, one in inner.items()} if inner else {},
            {name: self.value(one) for name, one in slots(value).items()},
        ]

    def _function(self, value: types.FunctionType) -> list[Any]:
        place = self._instance and self._instance.program.place(value.__code__)
        if place is None:
            raise TypeError("it holds a function that is not of this reward")
        parts = (value.__defaults__, value.__kwdefaults__, vars(value))
        cells = [self.value(cell) for cell in value.__closure__ or ()]
        return ["function", place, [self.value(part) for part in parts], cells]

    def _array(self, value: np.ndarray[Any, Any]) -> list[Any]:
        owner = value
        while isinstance(owner.base, np.ndarray):
            owner = owner.base
        if owner.base is not None and not isinstance(owner.base, bytes):
            raise TypeError(
                "it is a live view of the simulation, which changes at each step; keep a copy "
                "(`.copy()`)"
            )
        if owner is value or owner.base is not None or type(owner) is not np.ndarray:
            return ["array", *_memory(value), value.flags.writeable]
        offset = _start(value) - _start(owner)
        place = [list(value.shape), list(value.strides), offset, value.flags.writeable]
        return ["view", self.value(owner), _dtype(value.dtype), *place]

    def _generator(self, value: np.random.Generator) -> list[Any]:
        name = type(value.bit_generator).__name__
        if name not in _GENERATORS:
            raise TypeError(f"it holds a random generator of another kind ({name})")
        if has_spawned(value):
            raise TypeError("it holds a random generator that has spawned others; draw from it")
        return ["generator", name, self.value(dict(value.bit_generator.state))]


def _is_nan(value: Any) -> bool:
    # Not of a class of the reward, whose comparison would run.
    kind = type(value)
    number = kind in (float, complex) or (issubclass(kind, np.inexact) and not is_own_class(kind))
    return number and bool(value != value)


def _start(array: np.ndarray[Any, Any]) -> int:
    return int(array.__array_interface__["data"][0])


def _dtype(dtype: np.dtype[Any]) -> str:
    if dtype.metadata is not None:
        raise TypeError("it holds a dtype with metadata, which no checkpoint holds")
    if dtype.hasobject or dtype.names or dtype.kind in "VT":
        raise TypeError(f"it holds an array of {dtype}")
    return dtype.str


def _memory(array: np.ndarray[Any, Any]) -> list[Any]:
    order: Any = "F" if array.flags.f_contiguous and not array.flags.c_contiguous else "C"
    raw = base64.b64encode(array.tobytes(order)).decode()
    return [_dtype(array.dtype), list(array.shape), order, raw]
