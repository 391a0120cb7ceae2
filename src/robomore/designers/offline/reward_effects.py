"""How much each reward raises the results of the morphologies that were trained with it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable

Result = tuple[tuple[float, ...], str, float]
"""Parameters of a morphology, text of its reward, and the value that was measured."""


def by_morphology(results: Iterable[Result]) -> dict[tuple[float, ...], dict[str, float]]:
    """Return the results as one row of values by reward text per morphology."""
    rows: dict[tuple[float, ...], dict[str, float]] = defaultdict(dict)
    for parameters, source, value in results:
        rows[parameters][source] = value
    return rows


def reward_effects(results: Iterable[Result]) -> dict[str, float]:
    """Return each reward's mean difference from the means of its morphologies, shrunk towards 0."""
    differences: dict[str, list[float]] = defaultdict(list)
    for row in by_morphology(results).values():
        mean = sum(row.values()) / len(row)
        for source, value in row.items():
            differences[source].append(value - mean)
    return {source: sum(found) / (len(found) + 1) for source, found in differences.items()}
