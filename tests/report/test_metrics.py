"""Means, spreads and intervals of numbers with known answers."""

from __future__ import annotations

import pytest

from robomore.report.metrics import bootstrap_interval, ratio, spread


def test_a_single_value_has_no_spread() -> None:
    one = spread([3.0])
    assert (one.mean, one.std, one.interval) == (3.0, None, None)


def test_the_deviation_is_the_sample_deviation() -> None:
    assert spread([1.0, 2.0, 3.0]).std == pytest.approx(1.0)


def test_the_interval_holds_the_mean_and_stays_within_the_values() -> None:
    values = [1.0, 2.0, 3.0, 4.0, 10.0]
    low, high = bootstrap_interval(values)
    assert 1.0 <= low < 4.0 < high <= 10.0
    assert bootstrap_interval(values) == (low, high)


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
    assert found.interval is not None
    assert found.interval[0] < 5.0 < found.interval[1]


@pytest.mark.parametrize("below", [[], [0.0], [-1.0, 0.5]])
def test_a_ratio_to_nothing_or_to_a_loss_is_no_ratio(below: list[float]) -> None:
    assert ratio([1.0], below) is None
