"""Mean, low and high of each reward term over training."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robomore.types import TermStatistics

_MOST_TERMS = 64
"""Terms beyond so many are not recorded: names made up in every step must not fill the memory."""

_LONGEST_NAME = 80
"""Characters of a name that a message repeats."""

_SCALE = 2.0**-64
"""Sums are kept in this unit, so that those of very large terms stay finite. A power of two: no
digit is lost."""


class TermRecord:
    """What is known of each term that was ever a finite number.

    Sums are formed in the order of time, so that they do not depend on when anybody looks.
    """

    def __init__(self) -> None:
        self._terms: dict[str, list[float]] = {}  # name -> count, scaled sum, low, high

    def add(self, terms: Mapping[Any, Any]) -> None:
        """Record the terms of one call; what is not one finite number does not count.

        Raises:
            ValueError: a name is not one line of printable characters.
        """
        known, isfinite = self._terms, math.isfinite
        for name, term in terms.items():
            value = term if type(term) is float else as_number(term)
            if value is None or not isfinite(value):
                continue
            record = known.get(name)
            if record is not None:
                record[0] += 1
                record[1] += value * _SCALE
                if value < record[2]:
                    record[2] = value
                elif value > record[3]:
                    record[3] = value
            elif isinstance(name, str) and len(known) < _MOST_TERMS:
                if not name.isprintable():
                    raise ValueError(f"{name[:_LONGEST_NAME]!r} is no name of a term")
                known[name] = [1, value * _SCALE, value, value]

    def statistics(self) -> dict[str, TermStatistics]:
        """Return mean, low and high by name."""
        return {
            name: TermStatistics(min(max(total / count / _SCALE, low), high), low, high)
            for name, (count, total, low, high) in self._terms.items()
        }

    def sums(self) -> dict[str, tuple[int, float]]:
        """Return count and sum by name; the sum is infinite where it is beyond all floats."""
        return {
            name: (int(count), total / _SCALE) for name, (count, total, _, _) in self._terms.items()
        }

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything, as arrays."""
        return {
            "terms": np.frombuffer(json.dumps(list(self._terms)).encode(), np.uint8),
            "statistics": np.array(list(self._terms.values())).reshape(-1, 4),
        }

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue from what `state` returned."""
        names = json.loads(state["terms"].tobytes())
        self._terms = dict(zip(names, state["statistics"].tolist(), strict=True))


def as_number(value: Any) -> float | None:
    """Return `value` as a float where it is one number, bare or in an array of size 1."""
    kind = type(value)
    if kind is float:
        return value  # type: ignore[no-any-return]
    if kind is np.float64:
        return float(value)
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.item()
    if isinstance(value, (int, float, np.integer, np.floating, np.bool_)):
        try:
            return float(value)
        except OverflowError:
            return None
    return None
