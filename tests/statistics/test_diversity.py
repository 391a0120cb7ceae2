"""BLEU against sacrebleu 2.6, variation against SciPy, volumes against pymoo."""

from __future__ import annotations

import pytest

from robomore.statistics import (
    coefficient_of_variation,
    hypervolume,
    nondominated,
    self_bleu,
)
from robomore.statistics.diversity import bleu, tokens

TEXTS = [
    "the speed of the torso in x is rewarded and effort costs a little",
    "the speed of the torso is rewarded and falling costs a lot",
    "height of the torso is a bonus and effort costs a little",
    "return speed - 0.5 * np.square(action).sum(), terms",
]
SCORES = (0.61153805769010226, 0.56375603152592916, 0.53107253497886994, 0.032149545730574576)
"""`BLEU(tokenize="none", smooth_method="exp", effective_order=True)` of each against the others."""


def test_bleu_is_that_of_sacrebleu() -> None:
    split = [text.split() for text in TEXTS]
    for index, score in enumerate(SCORES):
        others = [*split[:index], *split[index + 1 :]]
        assert bleu(split[index], others) == pytest.approx(score)
    assert self_bleu(split) == pytest.approx(sum(SCORES) / 4)


def test_equal_texts_are_not_diverse_and_strange_ones_are() -> None:
    assert self_bleu([["a", "b", "c", "d", "e"]] * 3) == pytest.approx(1)
    assert self_bleu([[*"abcdefgh"], [*"ijklmnop"]]) < 0.1
    with pytest.raises(ValueError, match="at least two"):
        self_bleu([["a"]])


def test_programs_are_cut_into_words_and_signs() -> None:
    assert tokens("x += 0.5*self.v") == ["x", "+", "=", "0", ".", "5", "*", "self", ".", "v"]


def test_variation_is_the_mean_over_columns() -> None:
    # scipy.stats.variation(rows, ddof=1) is 0.5 and 0.31491832864888675.
    rows = [[1.0, -2.0, 0.0], [2.0, -3.0, 0.0], [3.0, -4.0, 0.0], [2.0, -5.0, 0.0]]
    assert coefficient_of_variation([row[:1] for row in rows]) == pytest.approx(0.408248290463863)
    assert coefficient_of_variation(rows) == pytest.approx((0.408248290463863 + 0.36885556) / 2)
    with pytest.raises(ValueError, match="two rows"):
        coefficient_of_variation(rows[:1])


def test_a_mean_that_is_0_but_for_rounding_has_no_variation() -> None:
    rows = [[0.1, 1.0], [0.2, 1.1], [-0.3, 0.9]]  # 0.1 + 0.2 - 0.3 is not 0
    assert coefficient_of_variation(rows) == pytest.approx(0.1)
    with pytest.raises(ValueError, match="no column"):
        coefficient_of_variation([row[:1] for row in rows])


def test_who_is_beaten_by_nobody() -> None:
    points = [(3, 1), (2, 2), (1, 3), (1, 2), (2, 2)]
    assert nondominated(points) == [True, True, True, False, True]


def test_hypervolume_is_that_of_pymoo() -> None:
    # Minimised there, with the reference point (1, 1, 1).
    points = [
        (0.637, 0.27, 0.041), (0.017, 0.813, 0.913), (0.607, 0.729, 0.544), (0.935, 0.816, 0.003),
        (0.857, 0.034, 0.73), (0.176, 0.863, 0.541), (0.3, 0.423, 0.028), (0.124, 0.671, 0.647),
        (0.615, 0.384, 0.997), (0.981, 0.686, 0.65), (0.688, 0.389, 0.135), (0.721, 0.525, 0.31),
    ]  # fmt: skip
    assert hypervolume([[1 - x for x in point] for point in points]) == pytest.approx(0.479247858)
    flat = [
        (0.486, 0.889), (0.934, 0.358), (0.572, 0.322), (0.594, 0.338), (0.392, 0.89),
        (0.227, 0.623), (0.084, 0.833), (0.787, 0.239), (0.876, 0.059), (0.336, 0.15),
    ]  # fmt: skip
    assert hypervolume([[1 - x for x in point] for point in flat]) == pytest.approx(0.640658)
    assert hypervolume([(2.0, -1.0)]) == 0
    assert hypervolume([]) == 0
