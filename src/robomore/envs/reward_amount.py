"""What a reward keeps outside of `self`, by name; how much it is, and whether a call changed it.

So a reward whose memory grows with every call is noticed, and one that keeps something for longer
than it may think.
"""

from __future__ import annotations

import hashlib
from collections import deque
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from robomore.envs.reward_objects import (
    ATOMS,
    address,
    cell_content,
    class_attributes,
    inside,
    is_own_class,
    is_own_function,
    native,
)
from robomore.envs.reward_program import RewardInstance

_MOST = 1_000_000


class Amount(NamedTuple):
    """How much something holds.

    Attributes:
        values: numbers, letters and objects; a bounded deque as if full.
        size: memory in bytes, roughly.
    """

    values: int = 0
    size: int = 0


def parts(instance: RewardInstance) -> dict[str, Any]:
    """Return what a reward keeps outside of `self`, by name.

    A name is that of a variable at the top level or of a closure, `function(argument=…)` for a
    default argument, or `owner.name` for an attribute of a function or a class.

    Args:
        instance: the reward that keeps it.
    """
    found: dict[str, Any] = {}
    for name, value in instance.names().items():
        if is_own_function(value, instance):
            found.update(_of_function(value))
        elif is_own_class(value):
            for inner, one in class_attributes(value).items():
                if is_own_function(one, instance):
                    found.update(_of_function(one))
                else:
                    found[f"{name}.{inner}"] = one
        elif address(value) is None:
            found[name] = value
    return found


def _of_function(function: Any) -> Iterator[tuple[str, Any]]:
    code, name = function.__code__, function.__name__
    positional = code.co_varnames[: code.co_argcount]
    defaults = function.__defaults__ or ()
    named = dict(zip(reversed(positional), reversed(defaults), strict=False))
    for argument, value in (named | (function.__kwdefaults__ or {})).items():
        yield f"{name}({argument}=…)", value
    for attribute, value in vars(function).items():
        yield f"{name}.{attribute}", value
    for variable, cell in zip(code.co_freevars, function.__closure__ or (), strict=True):
        for value in cell_content(cell):
            yield variable, value


def amount(value: Any, instance: RewardInstance) -> Amount:
    """Return how much something holds.

    Args:
        value: that the reward keeps.
        instance: the reward that keeps it.
    """
    values = size = 0
    for one, again in _all(value, instance):
        values += 1
        size += 0 if again else _size(one)
        if isinstance(one, str | bytes | bytearray):
            values += len(one)
        elif isinstance(one, np.ndarray):
            values += one.size
            size += 0 if again else one.nbytes
        elif isinstance(one, deque) and one.maxlen is not None:
            values += one.maxlen
        if values >= _MOST:
            break
    return Amount(values, size)


def _size(one: Any) -> int:
    # By the base's own method: those of the reward may do anything.
    kind: Any = native(one) or object
    return int(kind.__sizeof__(one))


def mark(value: Any, instance: RewardInstance) -> bytes:
    """Return a digest of what something holds: another one after a call has changed it.

    Args:
        value: that the reward keeps.
        instance: the reward that keeps it.
    """
    digest = hashlib.sha256()
    for count, (one, _) in enumerate(_all(value, instance)):
        kind: Any = native(one)
        if kind in (int, float, complex, str, bytes, bytearray):
            said = repr(kind(one))
        elif isinstance(one, np.ndarray | np.generic) and not one.dtype.hasobject:
            said = f"{one.shape} {one.tobytes().hex()}"
        elif type(one) is np.random.Generator:
            said = repr(one.bit_generator.state)
        else:
            said = f"{len(one) if kind is not None else one if type(one) in ATOMS else 0}"
        digest.update(f"{type(one).__name__} {said};".encode("utf-8", "surrogatepass"))
        if count >= _MOST:
            break
    return digest.digest()


def _all(value: Any, instance: RewardInstance) -> Iterator[tuple[Any, bool]]:
    """Yield a value and all that it holds, and whether it is an object that was there before."""
    seen: set[int] = set()
    waiting = [value]
    while waiting:
        one = waiting.pop()
        again = id(one) in seen
        yield one, again
        if type(one) not in ATOMS and not again and address(one) is None:
            seen.add(id(one))
            waiting += [inner for inner, _ in inside(one, instance)]
