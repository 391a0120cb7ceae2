"""The paper's algorithm on numbers: what is asked in which order, and what comes out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import pytest

from robomore.errors import NothingTrained, ProposalFailed
from robomore.search import coarse, final, fine, robomore
from robomore.search.measure import improves, ranked, top
from robomore.settings import SearchSettings
from robomore.types import Design, Morphology, Reward, Slot
from search.fakes import REFERENCE, CountingDesigner, Measuring, evaluation, numbers

T = TypeVar("T")


def design(body: float, reward: float) -> Design:
    return Design(Morphology((body,)), Reward(str(reward)))


def test_coarse_evaluates_the_whole_grid_in_one_batch_row_by_row() -> None:
    measuring = Measuring(lambda body, reward: body * reward)
    grid = coarse(CountingDesigner(), measuring, morphologies=3, rewards=2)
    assert [numbers(e.design) for e in grid] == [(b, r) for b in (1, 2, 3) for r in (10, 20)]
    (batch,) = measuring.batches
    assert [(t.place.morphology, t.place.reward) for t in batch] == [
        (i, j) for i in range(3) for j in range(2)
    ]


@pytest.mark.parametrize(("pairs", "share", "kept"), [(125, 0.05, 6), (15, 0.1, 2), (4, 0.05, 1)])
def test_top_keeps_the_share_and_at_least_one(pairs: int, share: float, kept: int) -> None:
    grid = [evaluation(design(i, 1), float(i)) for i in range(pairs)]
    best = top(grid, share, "efficiency")
    assert [e.efficiency for e in best] == [float(pairs - 1 - i) for i in range(kept)]


def test_failures_are_never_kept_and_never_improve() -> None:
    failed, good = evaluation(design(1, 1), None), evaluation(design(2, 1), -3.0)
    assert top([failed, good], 1.0, "efficiency") == [good]
    assert not improves(failed, good, "efficiency")
    assert improves(good, failed, "efficiency")
    assert not improves(good, good, "efficiency")


def test_equal_scores_keep_their_order() -> None:
    grid = [evaluation(design(i, 1), 5.0) for i in range(4)]
    assert ranked(grid, "efficiency") == grid


def test_a_grid_of_failures_says_why() -> None:
    measuring = Measuring(lambda body, reward: None)
    with pytest.raises(
        NothingTrained, match=r"all 4 candidates failed \(4 reward-failed\).*raised"
    ):
        robomore(CountingDesigner(), measuring, SearchSettings(2, 2), REFERENCE)


def test_fine_changes_the_body_then_the_reward_and_keeps_what_is_better() -> None:
    # Better until the body is 3; the reward cannot be improved.
    measuring = Measuring(lambda body, reward: -abs(body - 3) - abs(reward - 10))
    start = measuring.evaluation_of(design(1, 10))
    (best,) = fine(CountingDesigner(), measuring, [start], [start], "efficiency", max_cycles=10)
    assert numbers(best.design) == (3.0, 10.0)
    changes = [batch[0].place.changed for batch in measuring.batches]
    # Two cycles improve the body; the third improves neither and ends the branch.
    assert changes == ["morphology", "reward"] * 3
    assert [numbers(batch[0].design) for batch in measuring.batches] == [
        (2.0, 10.0),
        (2.0, 11.0),
        (3.0, 10.0),
        (3.0, 11.0),
        (4.0, 10.0),
        (3.0, 11.0),
    ]


def test_fine_branches_share_batches_and_stop_one_by_one() -> None:
    measuring = Measuring(lambda body, reward: min(body, 3) + min(reward, 10))
    starts = [measuring.evaluation_of(design(body, 10)) for body in (1, 3)]
    best = fine(CountingDesigner(), measuring, starts, starts, "efficiency", max_cycles=10)
    assert [numbers(e.design) for e in best] == [(3.0, 10.0), (3.0, 10.0)]
    assert [len(batch) for batch in measuring.batches] == [2, 2, 1, 1, 1, 1]


def test_a_branch_sees_the_grid_and_its_own_trials_only() -> None:
    designer = CountingDesigner()
    measuring = Measuring(lambda body, reward: body + reward)
    starts = [measuring.evaluation_of(design(body, 10)) for body in (1, 50)]
    fine(designer, measuring, starts, starts, "efficiency", max_cycles=2)
    grid = tuple(e.key for e in starts)
    first, second = designer.histories[2], designer.histories[3]
    assert first[:2] == second[:2] == grid
    assert len(first) == 4 and not set(first[2:]) & set(second[2:])


def test_max_cycles_bounds_a_search_that_always_improves() -> None:
    measuring = Measuring(lambda body, reward: body + reward)
    settings = SearchSettings(morphologies=2, rewards=2, survivors=0.25, max_cycles=4)
    best, *_ = robomore(CountingDesigner(), measuring, settings, REFERENCE)
    assert numbers(best.design) == (2.0 + 4, 20.0 + 4)


def test_the_objective_decides() -> None:
    light = replace(evaluation(design(1, 1), 9.0), fitness=1.0)
    far = replace(evaluation(design(2, 1), 5.0), fitness=7.0)
    assert top([light, far], 0.1, "efficiency") == [light]
    assert top([light, far], 0.1, "fitness") == [far]


def test_final_retrains_finalists_and_human_over_seeds_and_names_the_steadier_champion() -> None:
    scores = {1.0: iter([9.0, None]), 2.0: iter([3.0, 4.0]), 7.0: iter([1.0, 1.0])}
    measuring = Measuring(lambda body, reward: next(scores[body]))
    result = final(measuring, [design(1, 1), design(2, 1)], design(7, 1), 2, "efficiency")
    assert [e.efficiency for e in result.champion] == [3.0, 4.0]
    assert [e.efficiency for e in result.human] == [1.0, 1.0]
    (batch,) = measuring.batches
    assert [(t.place.changed, t.place.branch, t.place.repeat) for t in batch] == [
        ("champion", 0, 1),
        ("champion", 0, 2),
        ("champion", 1, 1),
        ("champion", 1, 2),
        ("human", 0, 1),
        ("human", 0, 2),
    ]


class Stubborn(CountingDesigner):
    """Has no proposal for some slots, named as `str(slot)` does."""

    def __init__(self, *without: str) -> None:
        super().__init__()
        self.without = without

    def __getattribute__(self, name: str) -> Any:
        found = super().__getattribute__(name)
        if not name.startswith(("propose_", "improve_")):
            return found

        def ask(slot: Slot, *given: Any) -> Any:
            if str(slot) in self.without:
                raise ProposalFailed(f"no {slot}")
            return found(slot, *given)

        return ask


def test_a_slot_without_proposal_leaves_its_row_or_column_empty() -> None:
    measuring = Measuring(lambda body, reward: body * reward)
    designer = Stubborn("coarse morphology 2", "coarse reward 1")
    grid = coarse(designer, measuring, morphologies=3, rewards=3)
    (batch,) = measuring.batches
    places = [(t.place.morphology, t.place.reward) for t in batch]
    assert places == [(0, 1), (0, 2), (2, 1), (2, 2)]
    # Those after it see only what there is.
    assert [numbers(e.design) for e in grid] == [(1, 10), (1, 20), (2, 10), (2, 20)]


@pytest.mark.parametrize("kind", ["morphology", "reward"])
def test_a_grid_without_any_proposal_ends_the_search_and_says_why(kind: str) -> None:
    designer = Stubborn(*(f"coarse {kind} {number}" for number in (1, 2)))
    measuring = Measuring(lambda body, reward: 1.0)
    with pytest.raises(NothingTrained, match=f"none of 2 slots for a {kind}.*no coarse {kind} 1"):
        robomore(designer, measuring, SearchSettings(2, 2), REFERENCE)
    assert not measuring.batches


def test_a_half_cycle_without_proposal_improves_nothing_and_the_others_go_on() -> None:
    measuring = Measuring(lambda body, reward: min(body, 4) + min(reward, 12))
    starts = [measuring.evaluation_of(design(body, 10)) for body in (1, 2)]
    designer = Stubborn("fine morphology 1 of branch 1", "fine reward 2 of branch 2")
    best = fine(designer, measuring, starts, starts, "efficiency", max_cycles=10)
    assert [numbers(e.design) for e in best] == [(4.0, 12.0), (4.0, 12.0)]
    assert [[t.place.branch for t in batch] for batch in measuring.batches[:4]] == [
        [1],
        [0, 1],
        [0, 1],
        [0],
    ]


def test_a_branch_without_any_proposal_keeps_its_best_and_ends() -> None:
    measuring = Measuring(lambda body, reward: body + reward)
    start = measuring.evaluation_of(design(1, 10))
    designer = Stubborn("fine morphology 1 of branch 1", "fine reward 1 of branch 1")
    assert fine(designer, measuring, [start], [start], "efficiency", max_cycles=5) == [start]
    assert not measuring.batches


def test_what_does_not_depend_on_each_other_is_asked_for_together() -> None:
    asked: list[int] = []

    def side_by_side(calls: Sequence[Callable[[], T]], /) -> list[T]:
        asked.append(len(calls))
        return list(reversed([call() for call in reversed(calls)]))

    measuring = Measuring(lambda body, reward: body + reward)
    settings = SearchSettings(morphologies=4, rewards=2, survivors=0.25, max_cycles=1)
    reflecting = CountingDesigner()
    turns = robomore(reflecting, measuring, settings, REFERENCE)
    assert robomore(reflecting, measuring, settings, REFERENCE, map_fn=side_by_side) == turns
    # Diversity Reflection goes in order; the two branches do not.
    assert asked == [2, 2]
    asked.clear()
    blind = CountingDesigner()
    blind.reflects = False
    robomore(blind, measuring, settings, REFERENCE, map_fn=side_by_side)
    assert asked == [4, 2, 2, 2]
    assert [slot.index for slot in blind.asked[:4]] == [3, 2, 1, 0]
