"""Close calls of a branch: what is compared, and what two seeds teach."""

from __future__ import annotations

import math

import pytest

from robomore.search.robomore.branch import Branch
from robomore.search.robomore.fine import fine
from robomore.types import Design, Evaluation, Morphology, Reward, Trial
from search.fakes import CountingDesigner, context, evaluation

GOAL = "efficiency"


def scored(score: float | None) -> Evaluation:
    return evaluation(Design(Morphology((1.0,)), Reward("1")), score)


def branch(best: float, again: float | None = None, close_call: float = 0.2) -> Branch:
    second = None if again is None else scored(again)
    return Branch(0, scored(best), [], close_call=close_call, again=second)


def test_the_score_is_the_mean_of_both_seeds() -> None:
    assert branch(100.0).score(GOAL) == 100.0
    assert branch(100.0, 80.0).score(GOAL) == 90.0


@pytest.mark.parametrize(
    ("new", "close"), [(81.0, True), (79.0, False), (124.0, True), (126.0, False), (None, False)]
)
def test_close_is_relative_to_the_larger(new: float | None, close: bool) -> None:
    assert branch(100.0).is_close(scored(new), GOAL) == close


def test_close_to_the_mean_and_not_to_the_first_seed() -> None:
    one = branch(100.0, 50.0)  # 75 in the mean
    assert one.is_close(scored(70.0), GOAL) and not one.is_close(scored(100.0), GOAL)


def test_the_papers_rule_knows_no_close_call() -> None:
    assert not branch(100.0, close_call=0.0).is_close(scored(100.0), GOAL)


def test_the_margin_is_the_root_of_the_mean_square() -> None:
    one = branch(100.0)
    one.note_seeds(scored(100.0), scored(90.0), GOAL)
    assert one.margin == 0.2  # one pair says little
    one.note_seeds(scored(60.0), scored(100.0), GOAL)
    assert one.margin == pytest.approx(math.sqrt((0.1**2 + 0.4**2) / 2))
    one.note_seeds(scored(100.0), scored(None), GOAL)
    assert len(one.differences) == 2


@pytest.mark.parametrize(
    ("again", "new", "second", "taken"),
    [
        (None, 101.0, None, True),
        (None, 99.0, None, False),
        (80.0, 91.0, None, True),  # of 90 in the mean
        (80.0, 89.0, None, False),
        (100.0, 120.0, 81.0, True),
        (100.0, 120.0, 79.0, False),
    ],
)
def test_means_are_compared(
    again: float | None, new: float, second: float | None, taken: bool
) -> None:
    one = branch(100.0, again)
    before, one.idle = one.again, 3
    proposal = scored(new)
    twice = None if second is None else scored(second)
    one.consider(proposal, twice, GOAL)
    assert (one.best is proposal) == taken
    assert one.idle == (0 if taken else 3)
    assert one.again is (twice if taken else before)


def test_the_designer_is_shown_the_second_seeds_too() -> None:
    seen: list[list[float | None]] = []

    class Watching(CountingDesigner):
        def improve_reward(
            self, slot: object, best: Evaluation, history: tuple[Evaluation, ...]
        ) -> Reward:
            seen.append([one.efficiency for one in history])
            return super().improve_reward(slot, best, history)  # type: ignore[arg-type]

    def measure(trials: list[Trial], *, budget_fraction: float = 1.0) -> list[Evaluation]:
        return [evaluation(one.design, 95.0 if one.place.repeat else 101.0) for one in trials]

    start = scored(100.0)
    fine(Watching(), measure, [start], [start], 1, 1, context(), 0.2)  # type: ignore[arg-type]
    # The grid, the new morphology, and both once more.
    assert seen == [[100.0, 101.0, 95.0, 95.0]]
