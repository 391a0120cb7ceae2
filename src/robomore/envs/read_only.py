"""MuJoCo's model and data as a reward sees them: everything can be read, nothing can be changed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from gymnasium.spaces import Box

from robomore.envs.data_fields import ON_REQUEST, REFUSED, refusal
from robomore.envs.missing import MissingAttributes

_PLAIN = frozenset({bool, int, float, str, bytes, tuple, type(None)})
"""Types of values that can be handed out as they are."""


class ReadOnly:
    """A MuJoCo struct whose arrays are read-only views of the live ones.

    Attributes that always lie at the same place in memory are looked up once.
    """

    def __init__(
        self,
        target: Any,
        lasting: Callable[[np.ndarray[Any, Any]], bool] = lambda array: True,
        on_request: Callable[[int], None] | None = None,
        constant: bool = False,
        missing: MissingAttributes | None = None,
    ) -> None:
        """Wrap `target`.

        Args:
            target: an `MjModel`, an `MjData`, or a part of one.
            lasting: whether an array stays where it is for as long as `target` lives.
            on_request: called with the place of its function in `REQUESTS` when a field that
                MuJoCo computes on request is looked up for the first time; only for data, of
                which some fields are refused.
            constant: whether its numbers never change, so that they are looked up once, and arrays
                are copies.
            missing: is told of attributes that are not there.
        """
        attributes = self.__dict__
        attributes["_target"] = target
        attributes["_lasting"] = lasting
        attributes["_on_request"] = on_request
        attributes["_constant"] = constant
        attributes["_missing"] = missing or MissingAttributes()

    def __getattr__(self, name: str) -> Any:
        attributes = self.__dict__
        if name.startswith("__") or "_target" not in attributes:
            raise AttributeError(name)  # copying asks before anything is there
        if self._on_request is not None:
            if name in REFUSED:
                raise AttributeError(refusal(name))
            if name in ON_REQUEST:
                self._on_request(ON_REQUEST[name])
        try:
            value = getattr(self._target, name)
        except AttributeError:
            holder = "self.model" if self._constant else "self.data"
            kind, known = type(self._target).__name__, lambda: dir(self._target)
            raise self._missing.error(holder, name, kind, known) from None
        if type(value) in _PLAIN:
            if self._constant:
                attributes[name] = value
            return value
        value = self._wrap(value)
        if isinstance(value, (ReadOnly, _Method)) or (
            isinstance(value, np.ndarray) and self._lasting(value)
        ):
            attributes[name] = value
        return value

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"a reward may read `{name}` of the simulation, but not set it")

    def __getitem__(self, index: Any) -> Any:
        return self._wrap(self._target[index])

    def __len__(self) -> int:
        return len(self._target)

    def __iter__(self) -> Iterator[Any]:
        return (self._wrap(item) for item in self._target)

    def __repr__(self) -> str:
        return f"<read-only {self._target!r}>"

    def _wrap(self, value: Any) -> Any:
        if isinstance(value, np.ndarray):
            return _unwritable(value) if self._constant else np.asarray(value.data.toreadonly())
        if type(value) in _PLAIN or isinstance(value, np.generic):
            return value
        if type(value).__module__.startswith("mujoco"):
            return ReadOnly(value, self._lasting, self._on_request, self._constant, self._missing)
        return _Method(value, self._wrap) if callable(value) else value


class _Method:
    """`data.body`, `model.joint`, …: what they return is read-only, and looked up once per name."""

    __slots__ = ("_found", "_method", "_wrap")

    def __init__(self, method: Callable[..., Any], wrap: Callable[[Any], Any]) -> None:
        self._method = method
        self._wrap = wrap
        self._found: dict[Any, Any] = {}

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        if named or len(arguments) != 1 or not isinstance(arguments[0], (int, str)):
            return self._wrap(self._method(*arguments, **named))
        key = arguments[0]
        found = self._found.get(key)
        if found is None:
            found = self._found[key] = self._wrap(self._method(key))
        return found


def _unwritable(array: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """Return a copy that cannot be made writable again, unlike one that owns its memory."""
    return np.frombuffer(array.tobytes(), array.dtype).reshape(array.shape)


def read_only_data(
    data: Any, on_request: Callable[[int], None], missing: MissingAttributes | None = None
) -> ReadOnly:
    """Return a read-only view of an `MjData`.

    Args:
        data: the live one.
        on_request: is given a place in `REQUESTS`, and must see to it that this function is called
            now and after every step from now on.
        missing: is told of attributes that are not there.
    """
    # qpos comes first in MuJoCo's fixed buffer; arrays elsewhere (contacts, constraints) move.
    start = data.qpos.ctypes.data

    def lasting(array: np.ndarray[Any, Any]) -> bool:
        return bool(0 <= array.ctypes.data - start < data.nbuffer)

    return ReadOnly(data, lasting, on_request, missing=missing)


@dataclass(frozen=True, slots=True)
class Bounds:
    """What a reward sees of a space: its numbers, and no random generator.

    Attributes:
        low: least values.
        high: greatest values.
        shape: of both.
        dtype: of both.
    """

    low: np.ndarray[Any, Any]
    high: np.ndarray[Any, Any]
    shape: tuple[int, ...]
    dtype: Any


def protect(value: Any) -> Any:
    """Return an attribute of a robot's environment as something that nobody can change."""
    if isinstance(value, np.ndarray):
        return _unwritable(value)
    if isinstance(value, dict):
        return MappingProxyType({name: protect(item) for name, item in value.items()})
    if isinstance(value, list | tuple):
        return tuple(protect(item) for item in value)
    if isinstance(value, set):
        return frozenset(value)
    if isinstance(value, Box):
        return Bounds(protect(value.low), protect(value.high), value.shape, value.dtype)
    return value
