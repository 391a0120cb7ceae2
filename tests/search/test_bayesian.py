"""The Gaussian process against scikit-learn, log expected improvement against exact arithmetic."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from robomore.search.bayesian.method import _learned, known_part
from robomore.search.bayesian.process import (
    GaussianProcess,
    Hyperparameters,
    fitted,
    log_expected_improvement,
)
from robomore.tasks import get_task
from robomore.tasks.fitness import Fitness
from robomore.tasks.unit_space import UnitSpace
from robomore.types import Design, Morphology, Reward
from search.fakes import evaluation

POINTS = np.array(
    [
        [0.637, 0.27, 0.041],
        [0.017, 0.813, 0.913],
        [0.607, 0.729, 0.544],
        [0.935, 0.816, 0.003],
        [0.857, 0.034, 0.73],
        [0.176, 0.863, 0.541],
    ]
)
VALUES = np.array([0.412, 1.043, -0.129, 1.366, -0.665, 0.352])
NEW = np.array([[0.615, 0.384, 0.997], [0.981, 0.686, 0.65], [0.688, 0.389, 0.135]])
PARAMETERS = Hyperparameters(np.array([0.4, 0.9, 2.0]), 1.3, 0.05)
"""What scikit-learn 1.9.1 was given: 1.3 * Matern([0.4, 0.9, 2.0], nu=2.5) + WhiteKernel(0.05)."""


def test_the_process_agrees_with_scikit_learn() -> None:
    process = GaussianProcess(POINTS, VALUES, PARAMETERS)
    mean, deviation = process.predict(NEW)
    assert mean == pytest.approx([-0.30448179298644495, 0.7274611555264858, 0.3272474027298822])
    assert deviation == pytest.approx(
        [0.4764859940012313, 0.4720897567941719, 0.2395459187411839], rel=1e-6
    )
    assert process.log_likelihood == pytest.approx(-7.981697670804104)
    # scikit-learn orders them signal, lengths, noise.
    signal, *lengths, noise = (
        *(0.15964673852692646, -0.2078021388750329, -0.5856956607660844),
        *(-0.9907408762452835, 0.14382403299295876),
    )
    assert process.gradient() == pytest.approx([*lengths, signal, noise])


def test_a_fitted_process_tells_which_parameter_matters() -> None:
    random = np.random.default_rng(0)
    points = random.random((16, 3))
    values = np.sin(6 * points[:, 0])
    process = fitted(points, (values - values.mean()) / values.std())
    lengths = process.parameters.lengths
    assert 3 * lengths[0] < min(lengths[1:])
    mean, _ = process.predict(points)
    assert np.corrcoef(mean, values)[0, 1] > 0.99


@pytest.mark.parametrize(
    ("gain", "exact"),
    [  # log(pdf(z) + z cdf(z)) by mpmath with 60 digits
        (2, 0.69738354578822831),
        (0.3, -0.5678171536779369),
        (-0.9, -2.2982829894596518),
        (-1.1, -2.6791783824760535),
        (-5, -16.74430116266099),
        (-40, -808.29856835661996),
        (-2e4, -200000020.72591365),
    ],
)
def test_log_expected_improvement_is_exact_however_small(gain: float, exact: float) -> None:
    found = log_expected_improvement(np.array([gain * 0.5 + 3]), np.array([0.5]), 3.0)
    assert found[0] == pytest.approx(exact + math.log(0.5), rel=1e-9, abs=1e-9)


def test_what_is_learned_is_the_fitness_and_failures_count_as_little() -> None:
    task = get_task("swimmer")
    space = UnitSpace(task)
    morphologies = [Morphology(task.reference), Morphology((0.5, 0.5, 0.5, 0.1, 0.1, 0.1))]
    found = [
        evaluation(Design(m, Reward("1")), score)
        for m, score in zip(morphologies, (8.0, None), strict=True)
    ]
    values = np.array([m.parameters for m in morphologies])
    learned = _learned(space, values, found, "efficiency")
    volume = task.volume(task.reference)
    assert known_part(space, values, "efficiency")[0] == pytest.approx(-math.log(volume))
    assert learned == pytest.approx([math.log(8 * volume), math.log(0.02 * 8 * volume)])
    assert _learned(space, values, found, "fitness")[0] == pytest.approx(math.log(4.0))
    # A fitness that may be below 0 has no logarithm, and tells good from bad all the same.
    frugal = Fitness.sum((1.0, "distance"), (-0.01, "energy"), unit="m")
    space = UnitSpace(replace(task, fitness=frugal))
    below = [replace(found[0], fitness=score) for score in (-0.5, -5.0)]
    assert _learned(space, values, below, "fitness").tolist() == [-0.5, -5.0]
    assert _learned(space, values, found, "fitness").tolist() == [4.0, 4.0]
