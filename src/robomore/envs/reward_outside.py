"""What a reward can reach and no checkpoint holds: modules, the robot's classes, and more.

All simulations share most of it. A reward that changes it would give other numbers after an
interruption, however late in a training that happens. So it is compared whenever the state of a
reward is written down, and at the end of a training.
"""

from __future__ import annotations

import builtins
import enum
import importlib
import types
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from robomore.envs.read_only import Bounds, ReadOnly
from robomore.envs.reward_objects import ATOMS, FixedObjects, class_attributes
from robomore.envs.reward_program import MODULE

_HEAP_TYPE = 1 << 9
"""Flag of classes that Python code made, and whose attributes can be set."""

_LAZY = frozenset({"__annotations__", "__dict__", "__weakref__", "__abstractmethods__"})
"""Attributes of classes that Python makes when somebody asks for them."""

_CONTAINERS = (dict, list, tuple, set, frozenset)

Parts = dict[Any, Any]


class Outside:
    """What the objects outside of a reward's own state were when it had not been called yet."""

    def __init__(
        self,
        modules: Iterable[str],
        robot: type,
        attributes: Iterable[Any],
        fixed: Iterable[FixedObjects],
    ) -> None:
        """Look at everything for the first time.

        Args:
            modules: that a reward can import.
            robot: the class of its `self`.
            attributes: values that its `self` begins with.
            fixed: of each simulation.
        """
        roots: list[tuple[str, Any]] = [("builtins", builtins)]
        roots += [(name, importlib.import_module(name)) for name in sorted(modules)]
        roots += [
            (one.__name__, one)
            for one in vars(np).values()
            if isinstance(one, types.ModuleType) and one.__name__.startswith("numpy.")
        ]
        robots = [(kind.__name__, kind) for kind in (*robot.__mro__, ReadOnly, Bounds)]
        robots += [("self", one) for one in attributes if not isinstance(one, ReadOnly)]
        packages = {name.partition(".")[0] for name in (*modules, "gymnasium", "robomore")}
        # Libraries enter their types into tables of NumPy when a trainer first loads them.
        shared = (it for it in _walk(roots, packages) if not isinstance(it[1], _CONTAINERS))
        self._seen = [*_walk(robots, packages), *shared]
        self._own = [
            (value, _own_parts(value))
            for one in fixed
            for value in one.values
            if not isinstance(value, types.CellType)
        ]

    def changed(self) -> str | None:
        """Return the name of something that has changed since, `None` if nothing has."""
        for name, value, before in self._seen:
            if (part := _difference(before, _parts(value) or {})) is not None:
                return f"{name}.{part}" if isinstance(part, str) else name
        for value, before in self._own:
            if (part := _difference(before, _own_parts(value))) is not None:
                kind = type(value).__name__
                name = getattr(value, "__qualname__", getattr(value, "__name__", kind))
                return f"{name}.{part}" if isinstance(part, str) else name
        return None


def _walk(roots: list[tuple[str, Any]], packages: set[str]) -> Iterator[tuple[str, Any, Parts]]:
    """Yield each object that can be changed with a name and its parts."""
    seen: set[int] = set()
    waiting = list(reversed(roots))
    while waiting:
        name, value = waiting.pop()
        if type(value) in ATOMS or id(value) in seen:
            continue
        seen.add(id(value))
        parts = _parts(value)
        if parts is None:
            continue
        yield name, value, parts
        waiting += [
            (f"{name}.{part}" if isinstance(part, str) else name, inner)
            for part, inner in parts.items()
            # What is private is often a cache.
            if not (isinstance(part, str) and part.startswith("_")) and _is_near(inner, packages)
        ]


def _is_near(value: Any, packages: set[str]) -> bool:
    """Whether an object is looked into: it is of one of the packages, or of no module."""
    if not isinstance(value, type | types.FunctionType):
        return True
    module = value.__module__
    return isinstance(module, str) and module.partition(".")[0] in packages


def _parts(value: Any) -> Parts | None:
    """Return what an object refers to, `None` if it cannot be changed."""
    if isinstance(value, types.ModuleType):
        # NumPy loads some of its modules late.
        parts = _plain(vars(value))
        return {name: one for name, one in parts if not isinstance(one, types.ModuleType)}
    if isinstance(value, type):
        return dict(_plain(vars(value))) if value.__flags__ & _HEAP_TYPE else None
    if isinstance(value, dict | types.MappingProxyType):
        return dict(enumerate(part for pair in value.items() for part in pair))
    if isinstance(value, list | tuple | set | frozenset):
        return dict(enumerate(value))
    inner = getattr(value, "__dict__", None)
    return dict(_plain(inner)) if isinstance(inner, dict) else None


def _plain(named: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    for name, value in named.items():
        if not (isinstance(name, str) and name.startswith("__") and name.endswith("__")):
            yield name, value


def _own_parts(value: Any) -> Parts:
    """Return what an object that the reward made refers to, besides what a checkpoint holds."""
    if isinstance(value, type):
        kept = class_attributes(value)
        parts: Parts = {
            n: one for n, one in vars(value).items() if n not in kept and n not in _LAZY
        }
        for name, one in list(parts.items()):
            if isinstance(one, dict | list):
                parts |= {(name, at): inner for at, inner in (_parts(one) or {}).items()}
        return {**parts, "__name__": value.__name__}
    if isinstance(value, enum.Enum):
        return {}
    if isinstance(value, types.FunctionType) and value.__module__ == MODULE:
        return {"__name__": value.__name__, "__doc__": value.__doc__, "__code__": value.__code__}
    return dict(getattr(value, "__dict__", {}))


def _difference(before: Parts, after: Parts) -> Any:
    """Return the name of a part that is another one now, `None` if none is."""
    nothing = object()
    for name in {**after, **before}:
        if before.get(name, nothing) is not after.get(name, nothing):
            return name
    return None
