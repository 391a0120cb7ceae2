"""Puts the objects of a reward back into the state that `reward_state.dump` wrote down.

No code comes out of a checkpoint: functions and classes are those of the reward, executed anew, and
everything else is looked up by name among what the process has loaded.
"""

from __future__ import annotations

import base64
import enum
import functools
import json
import types
from collections import defaultdict, deque
from collections.abc import Mapping
from typing import Any

import numpy as np

from robomore.envs.reward_objects import BASES, NATIVE, FixedObjects, at, class_attributes
from robomore.envs.reward_program import RewardInstance
from robomore.envs.reward_state import NANS

_NATIVE = {kind.__name__: kind for kind in NATIVE}
_CONSTANTS = {"Ellipsis": ..., "NotImplemented": NotImplemented}


def load(
    text: bytes, instance: RewardInstance | None, fixed: FixedObjects, known: Mapping[str, Any]
) -> dict[str, Any]:
    """Restore `instance` and return the attributes that the reward kept in `self`.

    Args:
        text: what `dump` returned.
        instance: the same reward, executed anew.
        fixed: made when `instance` was new.
        known: objects of the simulation by name, as `dump` was given.

    Raises:
        ValueError: the reward has made other objects than before.
    """
    state = json.loads(text)
    if len(fixed.values) != len(state["fixed"]):
        raise ValueError("the reward has other functions and classes each time it is executed")
    reader = _Reader(state["nodes"], instance, fixed.values, known)
    kept = {name: reader.value(value) for name, value in state["self"].items()}
    if instance is not None:
        for value, one in zip(fixed.values, state["fixed"], strict=True):
            reader.restore(value, one)
        module = {name: reader.value(value) for name, value in state["module"].items()}
        module["__builtins__"] = instance.namespace["__builtins__"]
        instance.namespace.clear()
        instance.namespace.update(module)
    return kept


class _Reader:
    """Reads values that `_Writer` wrote, each node once."""

    def __init__(
        self,
        nodes: list[Any],
        instance: RewardInstance | None,
        fixed: list[Any],
        known: Mapping[str, Any],
    ) -> None:
        self._nodes = nodes
        self._instance = instance
        self._fixed = fixed
        self._known = known
        self._made: dict[int, Any] = {}

    def value(self, written: Any) -> Any:
        """Return a value."""
        if not isinstance(written, list):
            return written
        kind, *content = written
        match kind:
            case "node":
                place = content[0]
                if place not in self._made:
                    self._node(place)
                return self._made[place]
            case "fixed":
                return self._fixed[content[0]]
            case "known":
                return self._known[content[0]]
            case "int":
                return int(content[0], 16)
            case "scalar":
                return _array(content)[()]
            case "dtype":
                return np.dtype(content[0])
            case "address":
                return at(content[0])
        return _CONSTANTS[content[0]] if content[0] in _CONSTANTS else complex(content[0])

    def restore(self, value: Any, written: Any) -> None:
        """Let a fixed object refer to what it did."""
        if written is None:
            return
        if isinstance(value, types.FunctionType):
            self._equip(value, written)
        elif isinstance(value, types.CellType):
            self._fill_cell(value, written)
        elif isinstance(value, enum.Enum):
            vars(value).update(self.value(written))
        else:
            for name in class_attributes(value).keys() - written.keys():
                type.__delattr__(value, name)
            for name, one in written.items():
                found = self.value(one)
                if vars(value).get(name, self) is not found:
                    type.__setattr__(value, name, found)

    def _equip(self, function: types.FunctionType, written: list[Any]) -> None:
        function.__defaults__, function.__kwdefaults__ = map(self.value, written[:2])
        inner = self.value(written[2])
        vars(function).clear()
        vars(function).update(inner)

    def _fill_cell(self, cell: types.CellType, written: list[Any]) -> None:
        if written:
            cell.cell_contents = self.value(written[0])
        else:
            del cell.cell_contents

    def _node(self, place: int) -> None:
        kind, *content = self._nodes[place]
        made = self._made
        match kind:
            case "object":
                self._object(place, *content)
            case "array":
                *memory, writeable = content
                made[place] = array = _array(memory)
                array.flags.writeable = writeable
            case "nan":
                module, scalar, *memory = content
                found = _array(memory)[()]
                made[place] = NANS[module] if module else found if scalar else found.item()
            case "view":
                made[place] = self._view(*content)
            case "cell":
                made[place] = cell = types.CellType()
                if content[0]:
                    self._fill_cell(cell, content[0])
            case "function":
                made[place] = function = self._function(content[0], content[2])
                self._equip(function, content[1])
            case "method":
                made[place] = types.MethodType(*map(self.value, content))
            case "builtin":
                made[place] = getattr(self.value(content[0]), content[1])
            case "partial":
                function, positional, named = map(self.value, content)
                made[place] = functools.partial(function, *positional, **named)
            case "slice" | "range":
                kinds = {"slice": slice, "range": range}
                made[place] = kinds[kind](*map(self.value, content[0]))
            case "generator":
                name, state = content
                bits = getattr(np.random, name)(0)
                bits.state = self.value(state)
                made[place] = np.random.Generator(bits)

    def _object(
        self,
        place: int,
        cls: Any,
        base: str,
        content: Any,
        extra: Any,
        inner: dict[str, Any],
        slots: dict[str, Any],
    ) -> None:
        cls, native = self.value(cls), _NATIVE.get(base)
        if native in (bytes, bytearray):
            content = base64.b64decode(content)
        if native is tuple:
            value = native.__new__(cls, [self.value(one) for one in content])
        elif native in (bytes, int, float, complex, str):
            value = native.__new__(cls, content if native is bytes else self.value(content))
        else:
            solid: Any = native or next(base for base in cls.__mro__ if base in BASES)
            value = solid.__new__(cls)
        self._made[place] = value
        if native is not None and issubclass(native, dict):
            for key, one in content:
                native.__setitem__(value, self.value(key), self.value(one))
            if isinstance(value, defaultdict):
                value.default_factory = self.value(extra)
        elif native is deque:
            deque.__init__(value, map(self.value, content), extra)
        elif native in (list, bytearray):
            native.extend(value, [self.value(one) for one in content])
        if inner:
            named = {name: self.value(one) for name, one in inner.items()}
            object.__getattribute__(value, "__dict__").update(named)
        for name, one in slots.items():
            object.__setattr__(value, name, self.value(one))

    def _function(self, place: int, cells: list[Any]) -> types.FunctionType:
        assert self._instance is not None
        code = self._instance.program.codes[place]
        closure = tuple(self.value(cell) for cell in cells)
        return types.FunctionType(code, self._instance.namespace, code.co_name, None, closure)

    def _view(
        self,
        owner: Any,
        dtype: str,
        shape: list[int],
        strides: list[int],
        offset: int,
        writeable: bool,
    ) -> np.ndarray[Any, Any]:
        memory = self.value(owner).ravel(order="K")
        if 0 in shape:
            return np.empty(shape, dtype)
        array: np.ndarray[Any, Any] = np.ndarray(shape, dtype, memory, offset, strides)
        array.flags.writeable = writeable
        return array


def _array(memory: list[Any]) -> np.ndarray[Any, Any]:
    dtype, shape, order, raw = memory
    found = np.frombuffer(base64.b64decode(raw), dtype=dtype).reshape(shape, order=order)
    return found.copy(order=order)
