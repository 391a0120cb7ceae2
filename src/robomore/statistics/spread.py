"""Statistics of numbers that were measured once for each training seed. Standard library alone."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import fmean

CONFIDENCE = 0.95
FEWEST = 5
"""Values from which on an interval is given; fewer are shown as they are."""
_RESAMPLES = 4_000


@dataclass(frozen=True, slots=True)
class Spread:
    """A number measured over training seeds.

    Attributes:
        values: one for each seed.
        mean: of the values; for a ratio the ratio of the means.
        interval: 95 % bootstrap interval of the mean; `None` for fewer than five values.
    """

    values: tuple[float, ...]
    mean: float
    interval: tuple[float, float] | None


def spread(values: Sequence[float]) -> Spread:
    """Return mean and interval of at least one value."""
    interval = bootstrap_interval(values) if len(values) >= FEWEST else None
    return Spread(tuple(values), fmean(values), interval)


def bootstrap_interval(values: Sequence[float]) -> tuple[float, float]:
    """Return the percentile bootstrap interval (95 %) of the mean of `values`.

    Resampling is seeded: the same values always give the same interval.
    """
    draw = random.Random(0)
    found = sorted(fmean(draw.choices(values, k=len(values))) for _ in range(_RESAMPLES))
    return _percentiles(found)


def ratio(above: Sequence[float], below: Sequence[float]) -> Spread | None:
    """Return the ratio of two means with one interval that has the spread of both sides in it.

    Args:
        above: values whose mean is divided; paired with nothing in `below`.
        below: values whose mean divides.

    Returns:
        `values` holds each of `above` over the mean of `below`. `None` where the ratio means
        nothing: one side is empty, or `below` has a mean that is not positive. The interval is
        `None` with fewer than five values on one side, and where a resampled mean of `below` is
        not positive.
    """
    if not above or not below or fmean(below) <= 0:
        return None
    base = fmean(below)
    interval = None
    if min(len(above), len(below)) >= FEWEST and min(below) > 0:
        draw = random.Random(0)
        found = sorted(
            fmean(draw.choices(above, k=len(above))) / fmean(draw.choices(below, k=len(below)))
            for _ in range(_RESAMPLES)
        )
        interval = _percentiles(found)
    return Spread(tuple(value / base for value in above), fmean(above) / base, interval)


def _percentiles(ascending: Sequence[float]) -> tuple[float, float]:
    tail = (1 - CONFIDENCE) / 2
    last = len(ascending) - 1
    return ascending[round(tail * last)], ascending[round((1 - tail) * last)]
