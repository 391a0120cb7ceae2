"""Histograms of values: what they stand for, and that learning brings them there."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from robomore.training.reward_scale import SPREAD
from robomore.training.value_bins import RANGE, cross_entropy, expected_value, smeared

LARGEST = RANGE * SPREAD


@pytest.mark.parametrize("bins", [2, 51, 101])
def test_a_smeared_value_is_a_histogram_around_it(bins: int) -> None:
    targets = jnp.linspace(-0.9 * LARGEST, 0.9 * LARGEST, 41)
    found = np.asarray(smeared(targets, bins))
    assert found.shape == (41, bins)
    np.testing.assert_allclose(found.sum(axis=1), 1, atol=1e-5)
    assert (found >= 0).all()
    width = 2 * LARGEST / bins
    centres = -LARGEST + width * (np.arange(bins) + 0.5)
    assert (np.abs(centres[found.argmax(axis=1)] - targets) <= width / 2 + 1e-3).all()


def test_its_mean_is_the_value_where_the_ends_do_not_cut_it() -> None:
    targets = jnp.linspace(-0.9 * LARGEST, 0.9 * LARGEST, 41)
    mean = expected_value(jnp.log(smeared(targets, 101) + 1e-30))
    np.testing.assert_allclose(mean, targets, atol=0.01)


def test_values_beyond_the_range_count_as_its_ends() -> None:
    ends = smeared(jnp.array([-LARGEST, LARGEST]), 101)
    beyond = smeared(jnp.array([-1e6, 1e6]), 101)
    np.testing.assert_array_equal(beyond, ends)
    assert np.isfinite(np.asarray(beyond)).all()


def test_cross_entropy_is_least_at_the_target_and_its_gradient_bounded() -> None:
    targets = jnp.array([3.0, -40.0])
    right = jnp.log(smeared(targets, 51) + 1e-30)[None]
    wrong = jnp.zeros_like(right)
    assert cross_entropy(right, targets) < cross_entropy(wrong, targets)
    slope = np.asarray(jax.grad(cross_entropy)(wrong, jnp.array([1e6, -1e6])))
    assert np.abs(slope).sum(axis=-1).max() <= 1  # 2 / batch of two
    logits = jnp.zeros((1, 2, 51))
    slope_at = jax.jit(jax.grad(cross_entropy))
    for _ in range(300):
        logits -= 2 * slope_at(logits, targets)
    np.testing.assert_allclose(expected_value(logits)[0], targets, atol=1.5)
