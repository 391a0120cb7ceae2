"""What a grid's screening would find if morphologies raced first, and rewards after them.

    python benchmarks/morphologies_first.py [--task half-cheetah] [--steps 150000]

It is a way to screen that the search does not have, tried on recorded grids (`screening.py`): each
morphology is trained under one reward, another one from morphology to morphology, the best go on
under one more, and those that are left are trained under all. Which reward comes first is shifted
once through, so each row is a mean over five races.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import fmean

import numpy as np
from numpy.typing import NDArray

from robomore.search.measure import survivor_count
from robomore.tasks import get_task
from screening import DATA, GRID, PARTS, STEPS, Row, lines, row_of, screen, whole

Scores = NDArray[np.float64]
"""Efficiency by morphology, reward and fifth of the way, in m/m^3."""


@dataclass(frozen=True)
class Heat:
    """A part of the race.

    Attributes:
        rewards: that each morphology has been tried with at its end.
        fifth: of the way, which these trainings have gone.
        keep_fraction: of all morphologies, that go on.
    """

    rewards: int
    fifth: int
    keep_fraction: float


WAYS = {
    "1 reward to 40 % keep 0.4, 2 to the end keep 0.12": (Heat(1, 2, 0.4), Heat(2, 5, 0.12)),
    "1 reward to 60 % keep 0.32, 2 to the end keep 0.12": (Heat(1, 3, 0.32), Heat(2, 5, 0.12)),
    "1 reward to the end keep 0.12": (Heat(1, 5, 0.12),),
}
"""Of each, the share of the steps is about that of the search's own screening."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--task", default="half-cheetah")
    parser.add_argument("--steps", type=int, default=STEPS, help="of every pair in the record")
    given = parser.parse_args()
    path = DATA / f"grid-{given.task}-{given.steps // 1000}k.csv"
    rows = whole([row_of(line) for line in lines(path)])
    scores = grid_of(rows)
    print(f"the grid of {given.task}, {len(scores)} morphologies, after the end\n")
    print(f"{'':<54}{'recall':>8}{'worth':>8}{'share of steps':>16}")
    found, true, fraction = screen(get_task(given.task), rows, GRID)
    recall = len(set(found) & set(true)) / len(true)
    line("halving (the default)", recall, sum(found.values()) / sum(true.values()), fraction)
    for name, heats in WAYS.items():
        races = [race(scores, heats, shift) for shift in range(GRID.rewards)]
        line(name, *(fmean(column) for column in zip(*races, strict=True)))


def grid_of(rows: Sequence[Row]) -> Scores:
    """Return a record's efficiencies."""
    numbers = {m: place for place, m in enumerate(sorted({row.morphology for row in rows}))}
    scores = np.full((len(numbers), GRID.rewards, PARTS), np.nan)
    for row in rows:
        scores[numbers[row.morphology], row.reward, row.fifth - 1] = row.fitness / row.volume
    return scores


def race(scores: Scores, heats: Sequence[Heat], shift: int) -> tuple[float, float, float]:
    """Return recall of the true best, worth of what is found over theirs, and share of the steps.

    Args:
        scores: of the whole grid.
        heats: in their order.
        shift: which reward the first morphology begins with.
    """
    count, rewards, _ = scores.shape
    first = (np.arange(rewards) + np.arange(count)[:, None] + shift) % rewards
    fifths = np.zeros((count, rewards), dtype=int)
    racing = np.arange(count)
    for heat in heats:
        standing = []
        for number in racing:
            tried = first[number, : heat.rewards]
            fifths[number, tried] = np.maximum(fifths[number, tried], heat.fifth)
            reached = scores[number, tried, fifths[number, tried] - 1]
            standing.append(np.log(np.maximum(reached, 1e-9)).mean())
        kept = math.ceil(heat.keep_fraction * count)
        racing = racing[np.argsort(standing)[::-1][:kept]]
    fifths[racing] = PARTS
    ends = scores[:, :, -1].ravel()
    best = survivor_count(GRID.survivors, ends.size)
    true = np.argsort(ends)[::-1][:best]
    found = np.argsort(np.where(fifths.ravel() == PARTS, ends, -np.inf))[::-1][:best]
    recall = len(set(found.tolist()) & set(true.tolist())) / best
    return recall, float(ends[found].sum() / ends[true].sum()), float(fifths.mean() / PARTS)


def line(name: str, recall: float, worth: float, fraction: float) -> None:
    """Print a way's row."""
    print(f"{name:<54}{recall:>8.2f}{worth:>8.3f}{fraction:>16.3f}")


if __name__ == "__main__":
    main()
