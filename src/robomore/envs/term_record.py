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

_MOST_PENDING = 64
"""Runs for many simulations that are recorded together; more at once is cheaper."""


class TermRecord:
    """What is known of each term that was ever a finite number.

    Sums are formed in the order of time, one step after the other, so that they do not depend on
    when anybody looks.
    """

    def __init__(self, n: int) -> None:
        """Prepare for `n` simulations."""
        self._n = n
        self._terms: dict[str, list[float]] = {}  # name -> count, sum, low, high
        self._names: tuple[Any, ...] = ()
        self._pending: list[list[Any]] = []  # of steps that are not yet counted

    def add(self, terms: Mapping[str, Any]) -> None:
        """Record the terms of one simulation; what is not one finite number does not count."""
        self._settle()
        for name, term in terms.items():
            value = as_number(term)
            if value is not None and math.isfinite(value):
                self._count(name, 1, value, value, value)

    def add_step(self, terms: Mapping[Any, float | NDArray[Any]]) -> None:
        """Record the terms of all simulations in one step.

        Args:
            terms: by name: (n,), not to be changed any more, or the number that it is in all
                simulations; NaN where it is none.
        """
        names = tuple(terms)
        if names != self._names or len(self._pending) >= _MOST_PENDING:
            self._settle()
            self._names = names
        self._pending.append(list(terms.values()))

    def statistics(self) -> dict[str, TermStatistics]:
        """Return mean, low and high by name."""
        self._settle()
        return {
            name: TermStatistics(total / count, low, high)
            for name, (count, total, low, high) in self._terms.items()
        }

    def sums(self) -> dict[str, tuple[int, float]]:
        """Return count and sum by name."""
        self._settle()
        return {name: (int(count), total) for name, (count, total, _, _) in self._terms.items()}

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything, as arrays."""
        self._settle()
        return {
            "terms": np.frombuffer(json.dumps(list(self._terms)).encode(), np.uint8),
            "statistics": np.array(list(self._terms.values())).reshape(-1, 4),
        }

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue from what `state` returned."""
        names = json.loads(state["terms"].tobytes())
        self._terms = dict(zip(names, state["statistics"].tolist(), strict=True))
        self._pending = []

    def _settle(self) -> None:
        pending, self._pending = self._pending, []
        of_term = np.empty((len(pending), self._n))
        for i, name in enumerate(self._names):
            for row, values in zip(of_term, pending, strict=True):
                row[:] = values[i]
            if np.isfinite(of_term).all():
                of_steps = zip(of_term.sum(1), of_term.min(1), of_term.max(1), strict=True)
                for total, low, high in of_steps:
                    self._count(name, self._n, float(total), float(low), float(high))
            else:
                for value in of_term[np.isfinite(of_term)].tolist():
                    self._count(name, 1, value, value, value)

    def _count(self, name: Any, count: int, total: float, low: float, high: float) -> None:
        known = self._terms.get(name)
        if known is not None:
            known[0] += count
            known[1] += total
            known[2] = min(known[2], low)
            known[3] = max(known[3], high)
        elif isinstance(name, str) and len(self._terms) < _MOST_TERMS:
            self._terms[name] = [count, total, low, high]


def as_number(value: Any) -> float | None:
    """Return `value` as a float where it is one number, bare or in an array of size 1."""
    if type(value) is float:
        return value
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.item()
    if isinstance(value, (int, float, np.integer, np.floating, np.bool_)):
        try:
            return float(value)
        except OverflowError:
            return None
    return None
