"""What the objects of a reward are: which it made itself, which exist without it, which can change.

A reward that is executed again makes the same functions and classes in the same order. These are
its fixed objects: a checkpoint names them by their place, and holds only what they refer to.
"""

from __future__ import annotations

import enum
import functools
import gc
import sys
import threading
import types
from collections import ChainMap, Counter, OrderedDict, UserDict, UserList, defaultdict, deque
from collections.abc import Iterator
from dataclasses import MISSING
from functools import cache
from typing import Any

import numpy as np

from robomore.envs.reward_imports import offered_modules
from robomore.envs.reward_program import MODULE, RewardInstance

ATOMS = frozenset({type(None), bool, int, float, str})
"""Exact types that JSON keeps as they are."""

NATIVE: tuple[type, ...] = (
    *(OrderedDict, defaultdict, Counter, dict, deque, list, tuple, bytearray),
    *(int, float, complex, str, bytes),
)
"""Types whose content can be kept, also that of a class that builds on one. The order of a set
depends on all that ever was in it, so it cannot be kept."""

BASES = frozenset({object, types.SimpleNamespace, ChainMap, UserDict, UserList, *NATIVE})
"""Types outside the reward whose instances hold nothing besides content and attributes."""

_DESCRIPTORS = (
    *(property, staticmethod, classmethod, functools.cached_property),
    *(types.MemberDescriptorType, types.GetSetDescriptorType),
)

_SETS = (set, frozenset)

_CONSTANTS = frozenset({"typing", "abc", "operator", "_operator"})
"""Modules whose objects never change, but for what they were given to hold."""

_LEAVES = (type, types.FunctionType, types.BuiltinFunctionType, enum.Enum, np.generic)
"""What a constant may refer to: functions and classes are fixed themselves, or of a module."""

_VALUES = (complex, bytes, type(...), type(NotImplemented), type(threading.RLock()))

_HOLDERS = (tuple, frozenset, slice, range, dict, types.MappingProxyType)
"""What may hold more of it. A dict is the inside of an object, or seen through a proxy."""


def is_own_function(value: Any, instance: RewardInstance) -> bool:
    """Whether `value` is a function that stands in the text of the reward."""
    return type(value) is types.FunctionType and instance.program.place(value.__code__) is not None


def is_own_class(value: Any) -> bool:
    """Whether `value` is a class that the reward defines."""
    return isinstance(value, type) and value.__module__ == MODULE


def address(value: Any) -> str | None:
    """Return `module:name` of an object that exists without the reward, `None` if it is none."""
    name: Any
    if isinstance(value, types.ModuleType):
        name = value.__name__
        return f"{name}:" if at(f"{name}:") is value and name != MODULE else None
    if isinstance(value, type | types.FunctionType | types.BuiltinFunctionType):
        name, inner = value.__module__, value.__qualname__
    elif isinstance(value, np.ufunc):
        name, inner = "numpy", value.__name__
    elif type(value).__module__ == MODULE:
        return None
    elif callable(value) and isinstance(getattr(value, "__name__", None), str):
        name, inner = getattr(value, "__module__", None), value.__name__
    else:
        return _sentinels().get(id(value))
    if not isinstance(name, str) or not isinstance(inner, str) or name == MODULE:
        return None
    found = f"{name}:{inner}"
    return found if at(found) is value else None


@cache
def _sentinels() -> dict[int, str]:
    """Return the addresses of what only stands for itself, such as `dataclasses.KW_ONLY`."""
    return {
        id(value): f"{module}:{name}"
        for module, offered in offered_modules().items()
        for name, value in vars(offered).items()
        if type(value).__module__ == module and not callable(value)
    }


def at(found: str) -> Any:
    """Return the object at an `address`, `None` if there is none."""
    name, _, inner = found.partition(":")
    value: Any = offered_modules().get(name) or sys.modules.get(name)
    for part in inner.split(".") if inner else ():
        value = getattr(value, part, None)
    return value


def native(value: Any) -> type | None:
    """Return the type in `NATIVE` that `value` is, or builds on."""
    return next((kind for kind in NATIVE if isinstance(value, kind)), None)


def check_class(kind: type) -> None:
    """Refuse a class whose instances may hold what cannot be seen.

    Raises:
        TypeError: saying what it holds.
    """
    for base in kind.__mro__:
        generic = base.__module__ in ("typing", "abc") or base.__module__ == "collections.abc"
        if not (base in BASES or is_own_class(base) or (generic and base is not kind)):
            raise TypeError(f"it holds {described(base)}")


def described(kind: type) -> str:
    """Return what an object of a type is, in words."""
    if kind is functools._lru_cache_wrapper:
        return (
            "a function with a cache (`functools.cache`, `functools.lru_cache`); compute the "
            "value once at the top level, or keep it in an attribute of `self`"
        )
    if issubclass(kind, types.GeneratorType):
        return "a generator; keep a number and count it up"
    if issubclass(kind, _SETS):
        return "a set, whose order cannot be kept; use a dict with these keys, or a list"
    if kind.__module__ == "itertools" or kind.__name__.endswith("iterator"):
        return f"an iterator ({kind.__qualname__}), whose place cannot be saved; keep a number"
    if kind.__module__.startswith("robomore.envs"):
        return (
            "a part of the simulation; read it anew at each call, or keep the numbers that you need"
        )
    own = "" if kind.__module__ in ("builtins", MODULE) else f"{kind.__module__}."
    return f"an object of type {own}{kind.__qualname__}"


def attributes(value: Any) -> dict[str, Any] | None:
    """Return the `__dict__` of an object, `None` where it has none."""
    try:
        found = object.__getattribute__(value, "__dict__")
    except AttributeError:
        return None
    return found if type(found) is dict else None


def slots(value: Any) -> dict[str, Any]:
    """Return the values that an object keeps in slots of the reward's classes."""
    found = {}
    for kind in type(value).__mro__:
        if not is_own_class(kind):
            continue
        for name, descriptor in vars(kind).items():
            if type(descriptor) is types.MemberDescriptorType:
                try:
                    found[name] = descriptor.__get__(value)
                except AttributeError:
                    continue  # nothing is there yet
    return found


def cell_content(cell: types.CellType) -> tuple[Any, ...]:
    """Return what a closure's cell holds; empty if nothing is there yet."""
    try:
        return (cell.cell_contents,)
    except ValueError:
        return ()


def class_attributes(kind: type) -> dict[str, Any]:
    """Return what the reward keeps in a class of its own; the inner workings are left out."""
    members: Any = ()
    if issubclass(kind, enum.Enum):
        members = kind.__members__  # fixed objects, each with attributes of its own
    return {
        name: value
        for name, value in vars(kind).items()
        if not (name.startswith("__") and name.endswith("__"))
        and type(value).__name__ != "_abc_data"
        and name not in members
        and not (members != () and name.startswith("_") and name.endswith("_"))
    }


class FixedObjects:
    """The functions, cells, classes and constants that a new instance of a reward has made.

    Attributes:
        values: always in the same order for the same text.
    """

    def __init__(self, instance: RewardInstance | None) -> None:
        """Find them; `instance` must not have been called yet."""
        self.values: list[Any] = []
        if instance is not None:
            self._find(instance)
        self._places = {id(value): place for place, value in enumerate(self.values)}
        self._members = {id(one): list(one) for one in self.values if isinstance(one, _SETS)}

    def place(self, value: Any) -> int | None:
        """Return the place of `value`, `None` if it is not fixed, or a set that has changed."""
        place = self._places.get(id(value))
        if isinstance(value, set) and place is not None and list(value) != self._members[id(value)]:
            return None
        return place

    def _find(self, instance: RewardInstance) -> None:
        seen: set[int] = set()
        kept: list[Any] = []  # so that no identity is used twice
        waiting = [(value, False) for value in reversed(instance.names().values())]
        while waiting:
            value, in_class = waiting.pop()
            if type(value) in ATOMS or id(value) in seen or address(value) is not None:
                continue
            seen.add(id(value))
            kept.append(value)
            if _is_fixed(value, instance, in_class):
                self.values.append(value)
            waiting += reversed(list(inside(value, instance)))


def _is_fixed(value: Any, instance: RewardInstance, in_class: bool) -> bool:
    kind = type(value)
    if kind is types.CellType or is_own_function(value, instance) or is_own_class(value):
        return True
    if isinstance(value, enum.Enum) and is_own_class(kind):
        return True
    if _is_typing(kind):
        return is_constant(value)
    if isinstance(value, _DESCRIPTORS):
        return is_constant({**(attributes(value) or {}), **slots(value)})
    if kind in _SETS:
        # Objects are ordered by where they lie in memory, which is never the same.
        return all(type(one) in ATOMS for one in value)
    # What the standard library put into a class: `_tuplegetter`, `_make`, …
    if in_class and (kind is types.FunctionType or kind.__module__.startswith("_collections")):
        return is_constant(attributes(value) or {})
    return False


def _is_typing(kind: type) -> bool:
    return kind.__module__ in _CONSTANTS or kind in (types.GenericAlias, types.UnionType)


def is_constant(value: Any) -> bool:
    """Whether nothing that changes can be kept in what an object refers to.

    A list that is an argument of `typing.Annotated`, say, can be had back, and no checkpoint holds
    it.
    """
    seen: set[int] = set()
    waiting = [value]
    while waiting:
        one = waiting.pop()
        if id(one) in seen or isinstance(one, _LEAVES):
            continue
        seen.add(id(one))
        kind = type(one)
        if kind in ATOMS or kind in _VALUES or address(one) is not None:
            continue
        if isinstance(one, np.dtype) and one.metadata is None:
            continue
        if kind not in _HOLDERS and not _is_typing(kind):
            return False
        waiting += gc.get_referents(one)
    return True


def inside(value: Any, instance: RewardInstance) -> Iterator[tuple[Any, bool]]:
    """Yield what an object refers to, and whether it does as a class."""
    kind = type(value)
    if kind is types.FunctionType:
        if is_own_function(value, instance):
            inner = (
                value.__defaults__,
                value.__kwdefaults__,
                vars(value),
                *(value.__closure__ or ()),
            )
            yield from ((one, False) for one in inner)
    elif kind is types.CellType:
        yield from ((one, False) for one in cell_content(value))
    elif isinstance(value, type):
        yield from ((one, True) for one in class_attributes(value).values())
        for one in vars(value).values():
            if is_own_function(one, instance):
                yield one, True
        yield from ((one, False) for one in vars(value).get("_member_map_", {}).values())
        for part in vars(value).get("__dataclass_fields__", {}).values():
            yield from ((one, False) for one in (part.default, part.default_factory))
    elif isinstance(value, property):
        yield from ((one, True) for one in (value.fget, value.fset, value.fdel))
    elif isinstance(value, staticmethod | classmethod | types.MethodType):
        yield value.__func__, True
        yield getattr(value, "__self__", None), False
    elif isinstance(value, functools.cached_property):
        yield value.func, True
    elif isinstance(value, functools.partial):
        yield from ((one, False) for one in (value.func, *value.args, *value.keywords.values()))
    elif _is_typing(kind):
        yield from ((one, False) for one in gc.get_referents(value))
    elif value is not MISSING and not isinstance(value, np.ndarray | np.generic):
        yield from ((one, False) for one in _content(value))
        yield from ((one, False) for one in (attributes(value) or {}).values())
        yield from ((one, False) for one in slots(value).values())


def _content(value: Any) -> list[Any]:
    # By the base's own methods: those of the reward may do anything.
    kinds: tuple[Any, ...] = (list, tuple, deque)
    for kind in kinds:
        if isinstance(value, kind):
            return list(kind.__iter__(value))
    return [one for pair in dict.items(value) for one in pair] if isinstance(value, dict) else []
