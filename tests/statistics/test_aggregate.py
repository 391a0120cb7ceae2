"""Aggregates against rliable 1.2, computed once."""

from __future__ import annotations

import pytest

from robomore.statistics import (
    interquartile_mean,
    mean_of_all,
    probability_of_improvement,
    stratified_interval,
)

A = [
    [1.077, 0.533, 0.443, 0.424, 0.726, 0.302],
    [1.065, 1.092, 0.559, 0.839, 0.979, 2.97],
    [1.565, 0.852, 0.859, 1.979, 0.757, 1.339],
]
B = [
    [1.077, 0.288, 1.241, 0.252, 0.818],
    [0.725, 0.717, 0.327, 0.656, 0.243],
    [0.372, 1.979, 0.44, 0.517, 0.454],
]


def test_points_are_those_of_rliable() -> None:
    assert interquartile_mean(A) == pytest.approx(0.8805)
    assert interquartile_mean(B) == pytest.approx(0.5584444444444444)
    assert probability_of_improvement(A, B) == pytest.approx(0.7222222222222223)


def test_intervals_are_near_those_of_rliable() -> None:
    """They are drawn at random, by rliable with 50,000 resamples and another generator."""
    assert stratified_interval(interquartile_mean, A) == pytest.approx((0.7384, 1.1071), abs=0.02)
    assert stratified_interval(mean_of_all, B) == pytest.approx((0.4713, 0.9123), abs=0.02)
    found = stratified_interval(probability_of_improvement, A, B, resamples=1000)
    assert found == pytest.approx((0.5222, 0.9), abs=0.03)
    assert found == stratified_interval(probability_of_improvement, A, B, resamples=1000)


def test_tasks_may_have_different_numbers_of_runs() -> None:
    assert mean_of_all([[1.0], [2.0, 3.0]]) == 2
    assert stratified_interval(mean_of_all, [[1.0], [2.0, 2.0]]) == pytest.approx((5 / 3, 5 / 3))


def test_no_score_is_no_number() -> None:
    for empty in ([], [[]]):
        with pytest.raises(ValueError, match="no score"):
            interquartile_mean(empty)
    with pytest.raises(ValueError, match="each of the same tasks"):
        probability_of_improvement(A, B[:2])
