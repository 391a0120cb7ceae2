"""What a reward can reach and no checkpoint holds: modules, the robot's classes, and more.

All simulations share most of it. A reward that changes it would give other numbers after an
interruption, however late in a training that happens. So it is compared whenever the state of a
reward is written down, and at the end of a training.
"""

from __future__ import annotations

import _abc  # type: ignore[import-not-found]
import abc
import enum
import types
from collections import deque
from collections.abc import Hashable, Iterable, Iterator
from functools import lru_cache
from typing import Any, cast

import numpy as np

from robomore.envs.read_only import Bounds, ReadOnly
from robomore.envs.reward_imports import BUILTINS, offered_modules
from robomore.envs.reward_modules import MODULES
from robomore.envs.reward_objects import ATOMS, FixedObjects, class_attributes
from robomore.envs.reward_program import MODULE

_HEAP_TYPE = 1 << 9
"""Flag of classes that Python code made, and whose attributes can be set."""

_LAZY = frozenset({"__annotations__", "__dict__", "__weakref__"})
"""Attributes of classes that Python makes when somebody asks for them."""

_KNOWN = frozenset({MODULE, "builtins", *(name.partition(".")[0] for name in MODULES)})
"""Modules whose classes a reward can have."""

_SIMPLE = ATOMS | {
    *(bytes, types.CodeType, types.BuiltinFunctionType, types.WrapperDescriptorType),
    *(types.MemberDescriptorType, types.GetSetDescriptorType, types.MethodDescriptorType),
}
"""Types of what cannot be changed."""

_REGISTER = "register"
_REGISTRY = type(vars(abc.ABC)["_abc_impl"])

Parts = dict[Any, Any]


class Outside:
    """What the objects outside of a reward's own state were when it had not been called yet."""

    def __init__(
        self, robot: type, attributes: Iterable[Any], fixed: Iterable[FixedObjects]
    ) -> None:
        """Look at everything for the first time.

        Args:
            robot: the class of its `self`.
            attributes: values that its `self` begins with.
            fixed: of each simulation.
        """
        modules = offered_modules()
        roots: list[tuple[str, Any]] = [("builtins", BUILTINS), *modules.items()]
        robots = [(kind.__name__, kind) for kind in (*robot.__mro__, ReadOnly, Bounds)]
        robots += [("self", one) for one in attributes if not isinstance(one, ReadOnly)]
        self._settings = _settings()
        packages = {name.partition(".")[0] for name in (*modules, "gymnasium", "robomore")}
        self._seen = [*_walk([*roots, *robots], packages)]
        self._own = [
            (value, _own_parts(value))
            for one in fixed
            for value in one.values
            if not isinstance(value, types.CellType)
        ]

    def changed(self) -> str | None:
        """Return the name of something that has changed since, `None` if nothing has."""
        if _settings() != self._settings:
            return "np.errstate"
        for name, value, before in self._seen:
            if (part := _difference(before, _parts(value) or {})) is not None:
                return f"{name}.{part}" if isinstance(part, str) else name
        for value, before in self._own:
            if (part := _difference(before, _own_parts(value))) is not None:
                kind = type(value).__name__
                name = getattr(value, "__qualname__", getattr(value, "__name__", kind))
                return f"{name}.{part}" if isinstance(part, str) else name
        return None


def _settings() -> tuple[Any, ...]:
    """Return NumPy's settings, which a `with` that a reward never leaves changes."""
    return np.geterr(), np.geterrcall(), np.getbufsize(), np.get_printoptions()


def _walk(roots: list[tuple[str, Any]], packages: set[str]) -> Iterator[tuple[str, Any, Parts]]:
    """Yield each object that can be changed with a name and its parts."""
    seen: set[int] = set()
    waiting = list(reversed(roots))
    while waiting:
        name, value = waiting.pop()
        if id(value) in seen:
            continue
        seen.add(id(value))
        parts = _parts(value)
        if parts is None:
            continue
        if type(value) is not tuple:
            yield name, value, parts
        waiting += [
            (f"{name}.{part}" if isinstance(part, str) else name, inner)
            for part, inner in parts.items()
            if type(inner) not in _SIMPLE
            and id(inner) not in seen
            and _is_near(inner, packages)
            and not _is_cache(value, part, inner)
        ]


def _is_near(value: Any, packages: set[str]) -> bool:
    """Whether an object is looked into: it is of one of the packages, or of no module."""
    if not isinstance(value, type | types.FunctionType):
        return True
    module = value.__module__
    return isinstance(module, str) and module.partition(".")[0] in packages


def _is_cache(holder: Any, name: Any, inner: Any) -> bool:
    """Whether NumPy fills something itself, such as what `np.finfo` has computed once."""
    own = isinstance(holder, type) and holder.__module__.startswith("numpy")
    return own and isinstance(inner, dict) and isinstance(name, str) and name.startswith("_")


def _parts(value: Any) -> Parts | None:
    """Return what an object refers to, `None` if it cannot be changed."""
    if type(value) is types.FunctionType:
        defaults = {"__defaults__": value.__defaults__, "__kwdefaults__": value.__kwdefaults__}
        return {"__code__": value.__code__, **defaults, **value.__dict__}
    if isinstance(value, types.ModuleType):
        return {n: one for n, one in vars(value).items() if not isinstance(one, types.ModuleType)}
    if isinstance(value, type):
        if not value.__flags__ & _HEAP_TYPE:
            return None
        return {n: one for n, one in vars(value).items() if n not in _LAZY} | _registered(value)
    if isinstance(value, dict | types.MappingProxyType):
        return dict(enumerate(part for pair in value.items() for part in pair))
    if isinstance(value, list | tuple | set | frozenset | deque):
        return dict(enumerate(value))
    if isinstance(value, np.ndarray | bytearray):
        return {0: bytes(value)} if isinstance(value, bytearray) else {0: value.tobytes()}
    found = _in_slots(value)
    inner = getattr(value, "__dict__", None)
    if not isinstance(inner, dict):
        return found or None
    # SciPy writes some documentation of NumPy anew.
    return found | {name: one for name, one in inner.items() if name != "__doc__"}


def _in_slots(value: Any) -> Parts:
    """Return what an object keeps in slots of classes that Python code made."""
    return {
        name: getattr(value, name)
        for name in _slots(cast(Any, type(value)))
        if hasattr(value, name)
    }


@lru_cache(10_000)
def _slots(kind: Hashable) -> tuple[str, ...]:
    return tuple(
        name
        for base in cast(type, kind).__mro__
        if base.__flags__ & _HEAP_TYPE
        for name, one in vars(base).items()
        if type(one) is types.MemberDescriptorType
    )


def _registered(kind: type) -> Parts:
    """Return the classes that `register` of an abstract class was given, by weak references.

    Libraries that are loaded late register classes that a reward does not know.
    """
    if type(vars(kind).get("_abc_impl")) is not _REGISTRY:
        return {}
    found = {}
    for reference in _abc._get_dump(kind)[0]:
        registered = reference()
        if registered is not None and registered.__module__.partition(".")[0] in _KNOWN:
            found[_REGISTER, reference] = reference
    return found


def _is_registration(part: Any) -> bool:
    """Whether a part is of `_registered`; it goes when the class does, with another reward, say."""
    return type(part) is tuple and part[0] == _REGISTER


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
        for name, one in parts.get("__dataclass_fields__", {}).items():
            parts |= {(name, at): inner for at, inner in _in_slots(one).items()}
            parts |= {(name, at): inner for at, inner in (_parts(one.metadata) or {}).items()}
        own = {"__name__": value.__name__, "__bases__": value.__bases__}
        return {**parts, **_registered(value), **own}
    if isinstance(value, enum.Enum):
        return {}
    if isinstance(value, types.FunctionType) and value.__module__ == MODULE:
        return {"__name__": value.__name__, "__doc__": value.__doc__, "__code__": value.__code__}
    return dict(getattr(value, "__dict__", {}))


def _difference(before: Parts, after: Parts) -> Any:
    """Return the name of a part that is another one now, `None` if none is."""
    nothing = object()
    gone = [name for name in before if name not in after and not _is_registration(name)]
    for name in [*gone, *after]:
        one, other = before.get(name, nothing), after.get(name, nothing)
        if one is not other and not (type(one) is type(other) is bytes and one == other):
            return name
    return None
