"""Statistics of numbers that were measured once for each training seed. Standard library alone."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import fmean, stdev

CONFIDENCE = 0.95
_RESAMPLES = 4_000


@dataclass(frozen=True, slots=True)
class Spread:
    """A number measured over training seeds.

    Attributes:
        values: one for each seed.
        mean: of the values.
        std: sample standard deviation; `None` for a single value.
        interval: bootstrap interval of the mean; `None` for a single value.
    """

    values: tuple[float, ...]
    mean: float
    std: float | None
    interval: tuple[float, float] | None


def spread(values: Sequence[float]) -> Spread:
    """Return mean, standard deviation and interval of at least one value."""
    if len(values) < 2:
        return Spread(tuple(values), values[0], None, None)
    return Spread(tuple(values), fmean(values), stdev(values), bootstrap_interval(values))


def bootstrap_interval(
    values: Sequence[float], statistic: Callable[[Sequence[float]], float] = fmean
) -> tuple[float, float]:
    """Return the percentile bootstrap interval (95 %) of a statistic of `values`.

    Resampling is seeded: the same values always give the same interval. With two or three values
    the interval says little more than their range.
    """
    draw = random.Random(0)
    found = sorted(statistic(draw.choices(values, k=len(values))) for _ in range(_RESAMPLES))
    return _percentiles(found)


def ratio(above: Sequence[float], below: Sequence[float]) -> Spread | None:
    """Return the ratio of two means with its bootstrap interval.

    Args:
        above: values whose mean is divided; paired with nothing in `below`.
        below: values whose mean divides.

    Returns:
        `values` holds each of `above` over the mean of `below`. `None` where the ratio means
        nothing: one side is empty, or `below` has a mean that is not positive.
    """
    if not above or not below or fmean(below) <= 0:
        return None
    base = fmean(below)
    values = tuple(value / base for value in above)
    interval = None
    if len(above) > 1 and len(below) > 1 and min(below) > 0:
        draw = random.Random(0)
        found = sorted(
            fmean(draw.choices(above, k=len(above))) / fmean(draw.choices(below, k=len(below)))
            for _ in range(_RESAMPLES)
        )
        interval = _percentiles(found)
    deviation = stdev(values) if len(values) > 1 else None
    return Spread(values, fmean(values), deviation, interval)


def _percentiles(ascending: Sequence[float]) -> tuple[float, float]:
    tail = (1 - CONFIDENCE) / 2
    last = len(ascending) - 1
    return ascending[round(tail * last)], ascending[round((1 - tail) * last)]
