"""Diversity of proposals: what repeats an earlier one counts, too."""

from __future__ import annotations

import pytest

from robomore.runs.lineage import Record
from robomore.statistics import coefficient_of_variation
from robomore.studies.diversity import _self_bleu, _variation
from robomore.types import Design, Morphology, Place, Reward
from search.fakes import evaluation


def grid(morphologies: list[float], rewards: list[str]) -> list[Record]:
    return [
        Record(
            Place(stage="coarse", index=(row, column)),
            evaluation(Design(Morphology((value,)), Reward(text)), 1.0),
        )
        for row, value in enumerate(morphologies)
        for column, text in enumerate(rewards)
    ]


def test_repeated_morphologies_lower_the_variation() -> None:
    found = _variation(grid([1.0, 2.0, 2.0, 2.0], ["r"]))
    assert found == pytest.approx(coefficient_of_variation([(1.0,), (2.0,), (2.0,), (2.0,)]))
    assert found < _variation(grid([1.0, 2.0], ["r"]))  # type: ignore[operator]
    assert _variation(grid([1.0], ["r", "s"])) is None


def test_repeated_rewards_raise_the_self_bleu() -> None:
    texts = ["forward = self.speed + 1", "effort = -2 * abs(action)"]
    assert _self_bleu(grid([1.0, 2.0], [texts[0]] * 3)) == 1.0
    apart, repeated = (_self_bleu(grid([1.0], found)) for found in (texts, [*texts, texts[0]]))
    assert apart is not None and repeated is not None and apart < repeated
    assert _self_bleu(grid([1.0, 2.0], texts[:1])) is None


def test_comments_are_no_words() -> None:
    one, other = "forward = speed  # as fast as it can", "# another idea\nforward = speed"
    assert _self_bleu(grid([1.0], [one, other])) == pytest.approx(1.0)
