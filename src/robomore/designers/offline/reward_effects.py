"""How much each reward raises the results of the morphologies that were trained with it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping

Parameters = tuple[float, ...]


def by_morphology(
    results: Iterable[tuple[Parameters, str, float]],
) -> dict[Parameters, dict[str, float]]:
    """Return the results (parameters, reward text, value) as one row per morphology."""
    rows: dict[Parameters, dict[str, float]] = defaultdict(dict)
    for parameters, source, value in results:
        rows[parameters][source] = value
    return rows


def reward_effects(rows: Mapping[Parameters, Mapping[str, float]]) -> dict[str, float]:
    """Return each reward's mean difference from the means of its morphologies, shrunk towards 0."""
    differences: dict[str, list[float]] = defaultdict(list)
    for row in rows.values():
        mean = sum(row.values()) / len(row)
        for source, value in row.items():
            differences[source].append(value - mean)
    return {source: sum(found) / (len(found) + 1) for source, found in differences.items()}
