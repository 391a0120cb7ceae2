"""MuJoCo's model and data as a reward sees them: everything can be read, nothing can be changed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import MethodType
from typing import Any

import numpy as np
from gymnasium.spaces import Box

from robomore.envs.data_fields import ON_REQUEST, REFUSED, refusal
from robomore.envs.frozen import frozen, frozen_array
from robomore.envs.missing import MissingAttributes

_PLAIN = frozenset({bool, int, float, str, bytes, tuple, type(None)})
"""Types of values that can be handed out as they are."""


class _Source:
    """What stands behind a `ReadOnly`. A reward has none of it but the method `read`."""

    __slots__ = ("constant", "lasting", "missing", "on_request", "target")

    def __init__(
        self,
        target: Any,
        lasting: Callable[[np.ndarray[Any, Any]], bool],
        on_request: Callable[[int], None] | None,
        constant: bool,
        missing: MissingAttributes,
    ) -> None:
        self.target = target
        self.lasting = lasting
        self.on_request = on_request
        self.constant = constant
        self.missing = missing

    def read(self, name: str) -> tuple[Any, bool]:
        """Return an attribute, and whether it stays what it is.

        Raises:
            AttributeError: a reward cannot read it, or it is not there.
        """
        if self.on_request is not None:
            if name in REFUSED:
                raise AttributeError(refusal(name))
            if name in ON_REQUEST:
                self.on_request(ON_REQUEST[name])
        try:
            value = getattr(self.target, name)
        except AttributeError:
            holder = "self.model" if self.constant else "self.data"
            kind = type(self.target).__name__
            raise self.missing.error(holder, name, kind, self.known) from None
        if type(value) in _PLAIN:
            return value, self.constant
        wrapped = self.wrap(value)
        lasts = isinstance(wrapped, (ReadOnly, MethodType)) or (
            isinstance(wrapped, np.ndarray) and self.lasting(wrapped)
        )
        return wrapped, lasts

    def known(self) -> list[str]:
        """Return the names of what can be read."""
        refused = REFUSED if self.on_request is not None else frozenset()
        return [name for name in dir(self.target) if name not in refused]

    def wrap(self, value: Any) -> Any:
        """Return a value as something that cannot be changed."""
        if isinstance(value, np.ndarray):
            return frozen_array(value) if self.constant else _view(value)
        if type(value) in _PLAIN or isinstance(value, np.generic):
            return value
        if type(value).__module__.startswith("mujoco"):
            return ReadOnly(value, self.lasting, self.on_request, self.constant, self.missing)
        return _Finder(value, self.wrap).call if callable(value) else value


class _Cache:
    """Has the `__dict__` in which `ReadOnly` caches what it has looked up."""

    __slots__ = ("__dict__",)


class ReadOnly(_Cache):
    """A MuJoCo struct whose arrays are read-only views of the live ones.

    Attributes that always lie at the same place in memory are looked up once. Nobody else can keep
    something in this cache: `vars` of this object, and its `__dict__`, are refused.
    """

    __slots__ = ("_read",)

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
        source = _Source(target, lasting, on_request, constant, missing or MissingAttributes())
        _keep(self, "_read", source.read)

    @property
    def __dict__(self) -> dict[str, Any]:  # type: ignore[override]
        raise AttributeError("__dict__")

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(f"a reward cannot read `{name}` of the simulation", name=name)
        value, lasts = self._read(name)
        if lasts:
            _keep(self, name, value)
        return value

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"a reward may read `{name}` of the simulation, but not set it")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"a reward may read `{name}` of the simulation, but not remove it")

    def __getitem__(self, index: Any) -> Any:
        source = self._read.__self__
        return source.wrap(source.target[index])

    def __len__(self) -> int:
        return len(self._read.__self__.target)

    def __iter__(self) -> Iterator[Any]:
        return (self[index] for index in range(len(self)))

    def __dir__(self) -> list[str]:
        return dir(self._read.__self__.target)

    def __reduce_ex__(self, protocol: Any) -> Any:
        raise TypeError("a part of the simulation cannot be copied; copy its numbers")


_keep = object.__setattr__


class _Finder:
    """`data.body`, `model.joint`, …: what they return is read-only, and looked up once per name.

    A reward has the bound method `call`, on which nobody can set an attribute.
    """

    __slots__ = ("found", "method", "wrap")

    def __init__(self, method: Callable[..., Any], wrap: Callable[[Any], Any]) -> None:
        self.method = method
        self.wrap = wrap
        self.found: dict[Any, Any] = {}

    def call(self, *arguments: Any, **named: Any) -> Any:
        """Return what the method returns, read-only."""
        if named or len(arguments) != 1 or not isinstance(arguments[0], (int, str)):
            return self.wrap(self.method(*arguments, **named))
        key = arguments[0]
        found = self.found.get(key)
        if found is None:
            found = self.found[key] = self.wrap(self.method(key))
        return found


def _view(array: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """Return a read-only view whose `base` does not lead to the array that can be written."""
    view = np.from_dlpack(array)
    view.flags.writeable = False
    return view


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
    return frozen(value, _space)


def _space(value: Any) -> Any:
    if isinstance(value, Box):
        return Bounds(frozen_array(value.low), frozen_array(value.high), value.shape, value.dtype)
    return value
