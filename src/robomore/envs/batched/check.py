"""Whether a reward that ran for many simulations at once gave what it gives in each of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from robomore.envs.batched import state as batched_state
from robomore.envs.batched.group import Group
from robomore.envs.batched.trust import Way
from robomore.envs.batched.value import Values
from robomore.envs.term_record import as_number

RELATIVE = 1e-9
"""Largest difference of a number from the right one, as a share of its size."""

NOTHING = 1e-12
"""What is smaller than this share of the largest number at hand is the rounding of larger ones."""


@dataclass(slots=True)
class Result:
    """What one run for m simulations gave.

    Attributes:
        rewards: (m,) of the simulations in `after`.
        terms: by name: (m,), or what the term is in all simulations; NaN where it is no number.
        after: the simulations, and what the reward keeps in their `self` now.
        way: how it got there.
    """

    rewards: Values
    terms: Mapping[Any, Any]
    after: Group
    way: Way


def difference(
    result: Result,
    truths: Sequence[tuple[float, Mapping[str, Any]]],
    kept: Sequence[Mapping[str, Any]],
) -> str:
    """Return in words what is not as it is per simulation, or nothing.

    Args:
        result: of the run for all.
        truths: reward and terms of each simulation, run on its own.
        kept: what the reward keeps in the `self` of each.
    """
    numbers = [value for value, _ in truths]
    numbers += [number for _, terms in truths for number in _finite(terms).values()]
    nothing = NOTHING * max(map(abs, numbers), default=0.0)

    def close(one: Any, other: Any) -> bool:
        a, b = np.asarray(one, np.float64), np.asarray(other, np.float64)
        if a.shape != b.shape:
            return False
        size = np.maximum(np.abs(a), np.abs(b))
        with np.errstate(invalid="ignore"):
            near = np.abs(a - b) <= RELATIVE * size + nothing
        return bool(np.all(near | (a == b) | (np.isnan(a) & np.isnan(b))))

    for position, ((value, terms), own) in enumerate(zip(truths, kept, strict=True)):
        if not close(result.rewards[position], value):
            return "the reward"
        known = _finite(terms)
        ours = _finite(
            {name: term[position] if np.ndim(term) else term for name, term in result.terms.items()}
        )
        for name in known.keys() | ours.keys():
            if name not in known or name not in ours or not close(ours[name], known[name]):
                return f"the term `{name}`"
        for name in own.keys() | result.after.kept.keys():
            if (
                name not in own
                or name not in result.after.kept
                or not batched_state.same(result.after.kept[name], position, own[name], close)
            ):
                return f"`self.{name}`"
    return ""


def _finite(terms: Mapping[Any, Any]) -> dict[Any, float]:
    """Return the terms that count: those that are one finite number."""
    numbers = ((name, as_number(term)) for name, term in terms.items())
    return {name: number for name, number in numbers if number is not None and np.isfinite(number)}
