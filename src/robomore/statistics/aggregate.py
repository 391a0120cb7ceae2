"""Scores of a method over tasks and runs, put together as in rliable (Agarwal et al. 2021).

Scores come as one sequence for each task, with one number for each run of the method on it. They
have to be normalised, so that tasks can be compared.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from robomore.statistics.spread import CONFIDENCE

Array = NDArray[np.float64]
Scores = Sequence[Sequence[float]]
"""One sequence of runs for each task; tasks may have different numbers of runs."""

RESAMPLES = 2_000


def interquartile_mean(scores: Scores) -> float:
    """Return the mean of the middle half of all scores, over tasks and runs alike.

    A quarter of them, rounded down, is cut off at each end. One lucky run moves it less than it
    moves the mean, and a quarter of bad runs moves it more than it moves the median.

    Raises:
        ValueError: there is no score.
    """
    ordered = np.sort(_all(scores))
    cut = len(ordered) // 4
    return float(ordered[cut : len(ordered) - cut].mean())


def mean_of_all(scores: Scores) -> float:
    """Return the mean over all tasks and runs.

    Raises:
        ValueError: there is no score.
    """
    return float(_all(scores).mean())


def probability_of_improvement(scores: Scores, others: Scores) -> float:
    """Return how likely a run of one method beats a run of another on the same task.

    A tie counts half. It is the mean over the tasks, whose order is the same in both.

    Raises:
        ValueError: the tasks are not as many, or a task has no score.
    """
    if len(scores) != len(others) or not scores or not all(map(len, (*scores, *others))):
        raise ValueError("both methods need a score on each of the same tasks")
    wins = []
    for mine, theirs in zip(scores, others, strict=True):
        apart = np.subtract.outer(np.array(mine, float), np.array(theirs, float))
        wins.append(((apart > 0) + 0.5 * (apart == 0)).mean())
    return float(np.mean(wins))


def stratified_interval(
    statistic: Callable[..., float], *scores: Scores, resamples: int = RESAMPLES
) -> tuple[float, float]:
    """Return the percentile bootstrap interval (95 %) of a statistic of one or more methods.

    Runs are drawn anew within each task, never across tasks. Drawing is seeded: the same scores
    always give the same interval.

    Args:
        statistic: is called with as many methods' scores as are given.
        scores: of each method.
        resamples: how often runs are drawn.

    Raises:
        ValueError: there is no score.
    """
    random = np.random.default_rng(0)
    methods = [[np.array(runs, float) for runs in tasks] for tasks in scores]
    found = [
        statistic(
            *(
                [runs[random.integers(len(runs), size=len(runs))] for runs in tasks]
                for tasks in methods
            )
        )
        for _ in range(resamples)
    ]
    tail = 50 * (1 - CONFIDENCE)
    low, high = np.percentile(found, [tail, 100 - tail])
    return float(low), float(high)


def _all(scores: Scores) -> Array:
    flat = np.concatenate([np.asarray(runs, dtype=float) for runs in scores] or [np.empty(0)])
    if not len(flat):
        raise ValueError("there is no score")
    return flat
