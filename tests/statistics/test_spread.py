"""Means and intervals of numbers with known answers."""

from __future__ import annotations

import pytest

from robomore.runs.words import with_interval
from robomore.statistics.spread import FEWEST, bootstrap_interval, ratio, spread


@pytest.mark.parametrize("count", range(1, FEWEST))
def test_few_values_have_no_interval(count: int) -> None:
    one = spread([3.0] * count)
    assert (one.mean, one.interval, len(one.values)) == (3.0, None, count)


def test_the_interval_holds_the_mean_and_stays_within_the_values() -> None:
    values = [1.0, 2.0, 3.0, 4.0, 10.0]
    low, high = bootstrap_interval(values)
    assert 1.0 <= low < 4.0 < high <= 10.0
    assert spread(values).interval == (low, high)


def test_the_interval_of_many_values_is_near_the_normal_one() -> None:
    values = [float(i % 10) for i in range(400)]
    low, high = bootstrap_interval(values)
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
    above, below = [8.0, 9.0, 10.0, 11.0, 12.0], [2.0, 3.0, 4.0, 5.0, 6.0]
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


def test_a_mean_is_told_with_its_interval_or_with_its_values() -> None:
    assert with_interval(spread([3.0]), "m") == "3.000 m (1 seed)"
    assert with_interval(spread([3.0, 4.0]), "m") == "3.500 m (seeds: 3.00, 4.00)"
    five = spread([1.0, 2.0, 3.0, 4.0, 5.0])
    assert five.interval is not None
    low, high = five.interval
    assert with_interval(five) == f"3.000 (95 % interval {low:.2f} to {high:.2f}, 5 seeds)"
