"""Means and intervals of numbers with known answers."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from robomore.runs.words import with_interval
from robomore.statistics.spread import FEWEST, mean_interval, ratio, spread


@pytest.mark.parametrize("count", range(1, FEWEST))
def test_few_values_have_no_interval(count: int) -> None:
    one = spread([3.0] * count)
    assert (one.mean, one.interval, len(one.values)) == (3.0, None, count)


def test_the_interval_of_a_mean_is_that_of_scipy() -> None:
    values = [1.0, 2.0, 3.0, 4.0, 10.0]
    # scipy.stats.ttest_1samp(values, 0).confidence_interval()
    assert mean_interval(values) == pytest.approx((-0.389945, 8.389945), abs=1e-5)
    assert spread(values).interval == mean_interval(values)
    assert mean_interval([2.0] * 5) == (2.0, 2.0)


def test_five_values_hold_their_mean_as_often_as_is_said() -> None:
    draw = random.Random(0)
    found = [mean_interval([draw.gauss(3, 1) for _ in range(5)]) for _ in range(2000)]
    assert sum(low <= 3 <= high for low, high in found) / 2000 == pytest.approx(0.95, abs=0.015)
    sides = ([draw.lognormvariate(0, 0.5) for _ in range(5)] for _ in range(4000))
    ratios = [ratio(above, below) for above, below in zip(sides, sides, strict=True)]
    held = [one.interval[0] <= 1 <= one.interval[1] for one in ratios if one and one.interval]
    assert len(held) == 2000 and sum(held) / 2000 == pytest.approx(0.95, abs=0.015)


@pytest.mark.parametrize(("deviation", "low", "high"), [(0.1, 0.04, 0.05), (0.3, 0.13, 0.15)])
def test_the_best_of_four_alike_is_flattered_as_much_as_is_said(
    deviation: float, low: float, high: float
) -> None:
    drawn = np.random.default_rng(0).normal(1.0, deviation, (2000, 4, 5))
    best = [spread(one[one.mean(axis=1).argmax()].tolist()) for one in drawn]
    assert low < np.mean([one.mean for one in best]) - 1 < high
    held = [one.interval is not None and one.interval[0] <= 1 <= one.interval[1] for one in best]
    assert 0.89 < np.mean(held) < 0.935


def test_the_interval_of_a_ratio_is_welchs() -> None:
    above, below = [8.0, 9.0, 10.0, 11.0, 12.0], [2.0, 3.0, 4.0, 5.0, 6.0]
    found = ratio(above, below)
    assert found and found.interval
    low, high = found.interval
    # Relative squared errors of the means are 0.005 and 0.03125, so that 5.246 degrees are free:
    # scipy.stats.t.ppf(0.975, 5.246) is 2.534.
    assert low == pytest.approx(2.5 * math.exp(-2.534 * math.sqrt(0.03625)), rel=1e-3)
    assert low * high == pytest.approx(2.5**2)
    same = ratio([4.0] * 5, [2.0] * 5)
    assert same and same.interval == (2.0, 2.0)
    loss = ratio([-1.0] * 5, [2.0] * 5)
    assert loss and loss.interval is None


def test_the_interval_of_many_values_is_near_the_normal_one() -> None:
    values = [float(i % 10) for i in range(400)]
    low, high = mean_interval(values)
    # Mean 4.5, deviation 2.872, standard error 0.1436.
    assert low == pytest.approx(4.5 - 1.96 * 0.1436, abs=0.03)
    assert high == pytest.approx(4.5 + 1.96 * 0.1436, abs=0.03)


def test_a_ratio_divides_the_means() -> None:
    found = ratio([10.0, 20.0], [2.0, 4.0])
    assert found is not None
    assert found.mean == pytest.approx(5.0)
    assert found.values == pytest.approx((10 / 3, 20 / 3))
    assert found.interval is None


def test_the_interval_of_a_ratio_has_the_spread_of_both_sides() -> None:
    above, below = [5.0, 7.5, 10.0, 12.5, 15.0], [2.0, 3.0, 4.0, 5.0, 6.0]
    both, one, other = ratio(above, below), ratio(above, [4.0] * 5), ratio([10.0] * 5, below)
    assert both and one and other
    assert both.mean == one.mean == other.mean == pytest.approx(2.5)

    def width(interval: tuple[float, float] | None) -> float:
        assert interval is not None
        assert interval[0] < 2.5 < interval[1]
        return interval[1] - interval[0]

    assert width(both.interval) > max(width(one.interval), width(other.interval))


@pytest.mark.parametrize("below", [[], [0.0], [-1.0, 0.5]])
def test_a_ratio_to_nothing_or_to_a_loss_is_no_ratio(below: list[float]) -> None:
    assert ratio([1.0], below) is None


def test_a_ratio_whose_base_may_be_nothing_has_no_interval() -> None:
    found = ratio([1.0] * 5, [-0.5, 1.0, 1.0, 1.0, 1.0])
    assert found is not None
    assert found.interval is None


@pytest.mark.parametrize(
    ("above", "below", "told"),
    [
        ([10.0, 11.0, 12.0], [0.2, 2.0, 0.5], "12.2 (no interval: 3 seeds, and it takes 5)"),
        ([10.0], [2.0], "5.00 (no interval: 1 seed, and it takes 5)"),
        ([10.0] * 4, [2.0] * 5, "5.00 (no interval: 4 seeds over 5, and it takes 5 of each)"),
        (
            [3.0, 4.0, 5.0, 4.0, 3.5],
            [-0.5, 0.1, 0.6, -0.1, 0.05],
            "130 (no interval: the reference may be 0)",
        ),
        ([-1.0] * 5, [2.0] * 5, "-0.500 (no interval: the ratio is not positive)"),
    ],
)
def test_a_ratio_without_an_interval_says_why_and_shows_no_side_alone(
    above: list[float], below: list[float], told: str
) -> None:
    found = ratio(above, below)
    assert found is not None
    assert with_interval(found, digits=3) == told


def test_a_mean_is_told_with_its_interval_or_with_its_values() -> None:
    assert with_interval(spread([3.0]), "m") == "3.000 m (1 seed)"
    assert with_interval(spread([3.0, 4.0]), "m") == "3.500 m (seeds: 3.00, 4.00)"
    five = spread([1.0, 2.0, 3.0, 4.0, 5.0])
    assert five.interval is not None
    low, high = five.interval
    assert with_interval(five) == f"3.000 (95 % interval {low:.2f} to {high:.2f}, 5 seeds)"
