"""What a reward adds to the morphologies that were trained with it and with others."""

from __future__ import annotations

import pytest

from robomore.designers.offline.reward_effects import by_morphology, reward_effects

GRID = [
    ((float(row),), reward, row + value)
    for row in range(3)
    for reward, value in (("better", 1.0), ("worse", 0.0))
]


def test_an_effect_is_the_shrunk_difference_within_morphologies() -> None:
    assert reward_effects(GRID) == {
        "better": pytest.approx(3 * 0.5 / 4),
        "worse": pytest.approx(-3 * 0.5 / 4),
    }


def test_morphologies_with_one_reward_say_nothing() -> None:
    refined = [((10.0 + turn,), "better", 5.0) for turn in range(20)]
    assert reward_effects([*GRID, *refined]) == reward_effects(GRID)
    assert reward_effects(refined) == {"better": 0.0}


def test_seeds_of_one_pair_are_averaged() -> None:
    seeds = [((1.0,), "one", 1.0), ((1.0,), "one", 5.0), ((1.0,), "other", 1.0)]
    assert by_morphology(seeds) == {(1.0,): {"one": [1.0, 5.0], "other": [1.0]}}
    assert reward_effects(seeds) == {"one": 0.5, "other": -0.5}
