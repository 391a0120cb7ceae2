"""How much each reward raises the results of the morphologies that were trained with it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from statistics import fmean

Result = tuple[tuple[float, ...], str, float]
"""Parameters of a morphology, text of its reward, and the value that was measured."""


def by_morphology(results: Iterable[Result]) -> dict[tuple[float, ...], dict[str, list[float]]]:
    """Return the values of each morphology by reward text, one for each training seed."""
    rows: dict[tuple[float, ...], dict[str, list[float]]] = defaultdict(dict)
    for parameters, source, value in results:
        rows[parameters].setdefault(source, []).append(value)
    return rows


def reward_effects(results: Iterable[Result]) -> dict[str, float]:
    """Return each reward's mean difference from the means of its morphologies, shrunk towards 0.

    A morphology that was trained with one reward alone says nothing about any.
    """
    differences: dict[str, list[float]] = defaultdict(list)
    for row in by_morphology(results).values():
        means = {source: fmean(values) for source, values in row.items()}
        for source, mean in means.items():
            found = differences[source]
            if len(row) > 1:
                found.append(mean - fmean(means.values()))
    return {source: sum(found) / (len(found) + 1) for source, found in differences.items()}
