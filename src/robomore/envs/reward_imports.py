"""The modules as a reward sees them: what is public, without other modules and state that is kept.

Each is a module of its own with the names of the real one. So a reward cannot reach the global
generator of NumPy or Python, the private caches of a module, or `sys` through `statistics`. Tables
are read-only copies.
"""

from __future__ import annotations

import builtins
import importlib
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from statistics import NormalDist
from types import ModuleType
from typing import Any

from robomore.envs.frozen import frozen
from robomore.envs.reward_modules import MODULES, SEEDED, withheld

_ALSO = ("numpy.random", "numpy.exceptions")
"""Modules that are attributes of a module that a reward can import."""


class NotOffered(AttributeError):
    """A module has an attribute that a reward cannot use.

    Attributes:
        reason: why, and what to do instead.
    """

    def __init__(self, module: str, name: str, reason: str) -> None:
        """Say what and why."""
        super().__init__(f"a reward cannot use `{module}.{name}`: {reason}", name=name)
        self.reason = reason


@cache
def offered_modules() -> dict[str, ModuleType]:
    """Return, by name, all modules that a reward can have."""
    real = {name: importlib.import_module(name) for name in (*sorted(MODULES), *_ALSO)}
    inner = real["numpy.polynomial"]
    real |= {one.__name__: one for one in vars(inner).values() if _is_part(one, inner)}
    offered = {name: ModuleType(name, module.__doc__) for name, module in real.items()}
    for name, module in real.items():
        vars(offered[name]).update(_public(name, module, offered))
        vars(offered[name])["__getattr__"] = _absent(name, module, offered[name])
    return offered


def _is_part(value: Any, module: ModuleType) -> bool:
    if not isinstance(value, ModuleType):
        return False
    inside, _, name = value.__name__.rpartition(".")
    return inside == module.__name__ and not name.startswith("_")


def _public(name: str, module: ModuleType, offered: Mapping[str, ModuleType]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for one, value in vars(module).items():
        if one.startswith("_") or withheld(name, one) is not None:
            continue
        if isinstance(value, ModuleType):
            if value.__name__ in offered:
                found[one] = offered[value.__name__]
        elif name == "numpy.random" and one in SEEDED:
            found[one] = _seeded(one, value)
        else:
            found[one] = _Normal if value is NormalDist else frozen(value)
    return found


class _Normal(NormalDist):
    """Draws with a seed alone: without one, from the global generator of Python."""

    def samples(self, n: Any, *, seed: Any = None) -> list[float]:
        if seed is None:
            raise ValueError("`samples` needs a `seed`; or draw from `self.np_random`")
        return super().samples(n, seed=seed)


_Normal.__module__, _Normal.__name__, _Normal.__qualname__ = "statistics", *["NormalDist"] * 2


def _seeded(name: str, make: Callable[..., Any]) -> Callable[..., Any]:
    """Return a maker of random generators that asks for a seed: without one it takes chance."""

    def seeded(seed: Any = None, **more: Any) -> Any:
        if seed is None:
            raise ValueError(
                f"`np.random.{name}` needs a seed, so that a training can be repeated: "
                f"`np.random.{name}(0)`; or draw from `self.np_random`"
            )
        return make(seed, **more)

    seeded.__module__, seeded.__name__, seeded.__qualname__ = "numpy.random", name, name
    return seeded


def _absent(module: str, real: ModuleType, offered: ModuleType) -> Callable[[str], Any]:
    """Return what says why an attribute of a module is not there.

    Where the name may be misspelt, the error has the module whose names are near.
    """

    def plain(name: str) -> str:
        return f"module {module!r} has no attribute {name!r}"

    def absent(name: str) -> Any:
        if reason := withheld(module, name):
            raise NotOffered(module, name, reason)
        if not name.startswith("_"):
            try:
                value = getattr(real, name)
            except AttributeError as error:
                if str(error) == plain(name):
                    raise AttributeError(plain(name), name=name, obj=offered) from None
                raise  # NumPy says what to use in the place of an old name.
            if isinstance(value, ModuleType):
                raise NotOffered(module, name, "a reward has only the modules that it can import")
        raise AttributeError(plain(name), name=name, obj=offered)

    return absent


def _import(
    name: str,
    globals: Mapping[str, Any] | None = None,
    locals: Mapping[str, Any] | None = None,
    fromlist: Sequence[str] = (),
    level: int = 0,
) -> ModuleType:
    """Import for a reward. What is not for rewards is refused by `check_reward`, not here."""
    offered = offered_modules()
    if level == 0 and name in offered:
        return offered[name if fromlist else name.partition(".")[0]]
    return builtins.__import__(name, globals, locals, fromlist, level)


BUILTINS = ModuleType("builtins", builtins.__doc__)
"""Python's own names, with an import that gives the modules of `offered_modules`."""
vars(BUILTINS).update({**vars(builtins), "__import__": _import})
