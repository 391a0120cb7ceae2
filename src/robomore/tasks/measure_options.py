"""What may stand in the options of a measure: each check says what it wants in place of a value."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from typing import Any

OptionCheck = Callable[[Any], str]
"""Returns in words what may stand there, or nothing if the value may."""

_FARTHEST = 1000.0
"""Coordinate in m that a place may have along each axis."""


def number(low: float, high: float, unit: str = "", *, backward: bool = False) -> OptionCheck:
    """Return a check for a number.

    Args:
        low: the least one.
        high: the largest one.
        unit: of it, with what may help to find it.
        backward: whether the same numbers below 0 may stand there, too.
    """
    either = f" or from -{high:g} to -{low:g}" if backward else ""
    wanted = f"a number from {low:g} to {high:g}{either} {unit}".rstrip()

    def check(value: Any) -> str:
        fits = _is_number(value) and low <= (abs(value) if backward else value) <= high
        return "" if fits else wanted

    return check


def target(value: Any) -> str:
    """Want a place on the ground or in space."""
    wanted = f"(x, y) or (x, y, z) in m, each from -{_FARTHEST:g} to {_FARTHEST:g}"
    return "" if _is_place(value, (2, 3)) else wanted


def path(value: Any) -> str:
    """Want places on the ground, of which no two that follow one another are the same."""
    if not isinstance(value, Sequence) or not all(_is_place(one, (2,)) for one in value):
        return f"points (x, y) in m, each number from -{_FARTHEST:g} to {_FARTHEST:g}"
    again = [list(one) for one, two in itertools.pairwise(value) if tuple(one) == tuple(two)]
    if again:
        return f"each point once in a row, and {again[0]} stands there twice"
    return "" if len(value) > 1 else "two points (x, y) or more"


def part(value: Any) -> str:
    """Want the name of a part, or none."""
    return "" if isinstance(value, str) else "the name of a body, site or geom"


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _is_place(value: Any, sizes: Sequence[int]) -> bool:
    plain = isinstance(value, list | tuple) and len(value) in sizes
    return plain and all(_is_number(one) and abs(one) <= _FARTHEST for one in value)
