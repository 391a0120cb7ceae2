"""The paper's algorithm on numbers: what is asked in which order, and what comes out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import pytest

from robomore.errors import InputError, NothingTrained, ProposalFailed
from robomore.search.measure import improves, ranked, top
from robomore.search.robomore.branch import REPEAT, Branch
from robomore.search.robomore.coarse import coarse
from robomore.search.robomore.fine import fine
from robomore.search.robomore.method import RoboMoRe
from robomore.search.robomore.settings import RoboMoReSettings
from robomore.search.slim_reference import thinnest
from robomore.tasks import get_task
from robomore.types import Design, Evaluation, Morphology, Reward, Slot, Trial
from search.fakes import (
    CountingDesigner,
    Measuring,
    context,
    evaluation,
    numbers,
    robomore,
    sizes,
)

T = TypeVar("T")


def design(morphology: float, reward: float) -> Design:
    return Design(Morphology((morphology,)), Reward(str(reward)))


def test_coarse_evaluates_the_whole_grid_in_one_batch_row_by_row() -> None:
    measuring = Measuring(lambda morphology, reward: morphology * reward)
    grid = coarse(CountingDesigner(), measuring, sizes(3, 2), context())
    assert [numbers(e.design) for e in grid] == [(b, r) for b in (1, 2, 3) for r in (10, 20)]
    (batch,) = measuring.batches
    assert [t.place.index for t in batch] == [(i, j) for i in range(3) for j in range(2)]


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
    measuring = Measuring(lambda morphology, reward: None)
    with pytest.raises(
        NothingTrained, match=r"all 4 candidates failed \(4 reward-failed\).*raised"
    ):
        robomore(CountingDesigner(), measuring, sizes(2, 2))


def test_fine_changes_the_morphology_then_the_reward_and_keeps_what_is_better() -> None:
    # Better until the morphology is 3; the reward cannot be improved.
    measuring = Measuring(lambda morphology, reward: -abs(morphology - 3) - abs(reward - 10))
    start = measuring.evaluation_of(design(1, 10))
    (best,) = fine(CountingDesigner(), measuring, [start], [start], 10, 1, context())
    assert numbers(best.design) == (3.0, 10.0)
    changes = [batch[0].place.changed for batch in measuring.batches]
    # Two cycles improve the morphology; the third improves neither and ends the branch.
    assert changes == ["morphology", "reward"] * 3
    assert [numbers(batch[0].design) for batch in measuring.batches] == [
        (2.0, 10.0),
        (2.0, 11.0),
        (3.0, 10.0),
        (3.0, 11.0),
        (4.0, 10.0),
        (3.0, 11.0),
    ]


@pytest.mark.parametrize(
    ("improving", "kinds"),
    [
        # What improves goes on; what does not gives way once, and is tried again later.
        ("morphology", ["morphology"] * 6),
        ("reward", ["morphology"] + ["reward"] * 5),
        ("neither", ["morphology", "reward"] * 3),
    ],
)
def test_adaptive_turns_go_to_what_improves(improving: str, kinds: list[str]) -> None:
    def score(morphology: float, reward: float) -> float:
        sign = {"morphology": (1, -1), "reward": (-1, 1), "neither": (-1, -1)}[improving]
        return sign[0] * morphology + sign[1] * reward

    measuring = Measuring(score)
    settings = sizes(1, 1, survivors=1.0, max_cycles=3, patience=3, order="adaptive")
    designer = CountingDesigner()
    robomore(designer, measuring, settings)
    places = [batch[0].place for batch in measuring.batches[1:]]
    assert [place.changed for place in places] == kinds
    # Each turn has a number of its own, so that two of a kind in a row differ.
    assert [place.index for place in places] == [(0, turn) for turn in range(6)]
    asked = [(slot.kind, slot.index) for slot in designer.asked if slot.improves]
    assert asked == [(place.changed, place.index) for place in places]


def test_adaptive_turns_leave_what_has_nothing_more_to_improve() -> None:
    # The morphology improves three times, and then the reward does.
    measuring = Measuring(lambda m, r: min(m, 4) - 9 * (m > 4) + (r if m == 4 else 0))
    settings = sizes(1, 1, survivors=1.0, max_cycles=6, patience=9, order="adaptive")
    best, *_ = robomore(CountingDesigner(), measuring, settings)
    changed = [batch[0].place.changed for batch in measuring.batches[1:]]
    assert changed[:3] == ["morphology"] * 3
    assert changed.count("reward") >= 5
    assert numbers(best.design) == (4.0, 10.0 + changed.count("reward"))


def test_a_branch_ends_when_both_kinds_were_tried_on_its_best() -> None:
    # One reward improves, and nothing else does; then it is the rewards' turn twice.
    measuring = Measuring(lambda morphology, reward: min(reward, 11) - morphology)
    settings = sizes(1, 1, survivors=1.0, max_cycles=9, patience=1, order="adaptive")
    best, *_ = robomore(CountingDesigner(), measuring, settings)
    changed = [batch[0].place.changed for batch in measuring.batches[1:]]
    assert changed[:4] == ["morphology", "reward", "reward", "reward"]
    assert numbers(best.design) == (1.0, 11.0)
    assert "morphology" in changed[4:] and len(changed) == 6


def test_fine_branches_share_batches_and_stop_one_by_one() -> None:
    measuring = Measuring(lambda morphology, reward: min(morphology, 3) + min(reward, 10))
    starts = [measuring.evaluation_of(design(morphology, 10)) for morphology in (1, 3)]
    best = fine(CountingDesigner(), measuring, starts, starts, 10, 1, context())
    assert [numbers(e.design) for e in best] == [(3.0, 10.0), (3.0, 10.0)]
    assert [len(batch) for batch in measuring.batches] == [2, 2, 1, 1, 1, 1]


def test_a_branch_sees_the_grid_and_its_own_trials_only() -> None:
    designer = CountingDesigner()
    measuring = Measuring(lambda morphology, reward: morphology + reward)
    starts = [measuring.evaluation_of(design(morphology, 10)) for morphology in (1, 50)]
    fine(designer, measuring, starts, starts, 2, 1, context())
    grid = tuple(e.key for e in starts)
    first, second = designer.histories[2], designer.histories[3]
    assert first[:2] == second[:2] == grid
    assert len(first) == 4 and not set(first[2:]) & set(second[2:])


class Noisy(Measuring):
    """Each training seed adds its own noise to a design's score."""

    def __init__(
        self, score: Callable[[float, float], float], noise: Callable[[float, float, int], float]
    ) -> None:
        super().__init__(score)
        self.noise = noise

    def __call__(
        self, trials: Sequence[Trial], *, budget_fraction: float = 1.0
    ) -> list[Evaluation]:
        self.batches.append(list(trials))
        return [self.seeded(trial.design, trial.place.repeat) for trial in trials]

    def seeded(self, one: Design, repeat: int) -> Evaluation:
        morphology, reward = numbers(one)
        noise = self.noise(morphology, reward, repeat)
        found = evaluation(one, self.score(morphology, reward) * (1 + noise))
        return replace(found, key=f"{found.key}-{repeat}")


def unlucky_second(morphology: float, reward: float, repeat: int) -> float:
    """The proposal (2, 10) has bad luck with its first seed, and good luck with its second."""
    return (-0.1 if repeat == 0 else 0.1) if (morphology, reward) == (2, 10) else 0.0


@pytest.mark.parametrize(("close_call", "found"), [(0.0, (1.0, 10.0)), (0.2, (3.0, 10.0))])
def test_a_close_call_is_decided_by_a_second_seed(
    close_call: float, found: tuple[float, float]
) -> None:
    # Better by 4 % with each morphology up to 3; no other reward is any good.
    measuring = Noisy(lambda m, r: (100 + 4 * min(m, 3)) * (r == 10), unlucky_second)
    start = measuring.seeded(design(1, 10), 0)
    (best,) = fine(CountingDesigner(), measuring, [start], [start], 9, 1, context(), close_call)
    assert numbers(best.design) == found and best.key.endswith("-0")
    repeats = [[t.place.repeat for t in batch] for batch in measuring.batches]
    if not close_call:
        assert repeats == [[0], [0]]
        return
    # The start is measured again with the first close call only, and so is each new best.
    assert repeats[:3] == [[0], [REPEAT, REPEAT], [0]]
    assert all(len(batch) == 1 for batch in repeats[2:])
    again = measuring.batches[1]
    assert [numbers(t.design) for t in again] == [(2.0, 10.0), (1.0, 10.0)]
    assert [t.place.changed for t in again] == ["morphology", ""]
    assert len({t.place for batch in measuring.batches for t in batch}) == sum(map(len, repeats))


def test_a_lucky_first_seed_does_not_win_a_close_call() -> None:
    measuring = Noisy(
        lambda m, r: 100.0,
        lambda m, r, repeat: 0.1 * (m == 2 and repeat == 0) - 0.2 * (m == 2 and repeat == REPEAT),
    )
    start = measuring.seeded(design(1, 10), 0)
    (best,) = fine(CountingDesigner(), measuring, [start], [start], 1, 1, context(), 0.2)
    assert numbers(best.design)[0] == 1.0


def test_a_clear_call_and_a_failure_cost_no_second_seed() -> None:
    measuring = Noisy(lambda m, r: 10.0**m * (r == 10), lambda m, r, repeat: 0.0)
    start = measuring.seeded(design(1, 10), 0)
    fine(CountingDesigner(), measuring, [start], [start], 3, 1, context(), 0.2)
    assert all(t.place.repeat == 0 for batch in measuring.batches for t in batch)
    failing = Measuring(lambda m, r: None)
    assert fine(CountingDesigner(), failing, [start], [start], 3, 1, context(), 0.2) == [start]
    assert len(failing.batches) == 2


def test_the_measured_spread_of_the_seeds_takes_the_place_of_the_first_guess() -> None:
    first = evaluation(design(1, 10), 100.0)
    branch = Branch(0, first, [], close_call=0.2)
    other = evaluation(design(2, 10), 85.0)
    assert branch.is_close(other, "efficiency")
    for second in (101.0, 99.0):
        branch.note_seeds(first, evaluation(design(1, 10), second), "efficiency")
    assert branch.margin == pytest.approx(0.01, rel=0.02)
    assert not branch.is_close(other, "efficiency")


def test_a_second_seed_that_fails_counts_against_a_design() -> None:
    first, second = evaluation(design(1, 10), 100.0), evaluation(design(1, 10), 90.0)
    branch = Branch(0, first, [], close_call=0.2, again=second)
    branch.consider(evaluation(design(2, 10), 105.0), evaluation(design(2, 10), None), "efficiency")
    assert branch.best is first


def test_the_rule_by_seeds_is_a_setting_that_ranks_by_the_mean() -> None:
    # (2, 20) is best by its first seed, but not with its second.
    measuring = Noisy(
        lambda m, r: 100.0,
        lambda m, r, repeat: (0.02 if repeat == 0 else -0.1) * ((m, r) == (2, 20)),
    )
    settings = sizes(2, 2, survivors=1.0, max_cycles=1, improvement="seeds")
    best, *_ = robomore(CountingDesigner(step=0.5), measuring, settings)
    assert numbers(best.design) != (2.0, 20.0)
    paper, *_ = robomore(CountingDesigner(step=0.5), measuring, sizes(2, 2, max_cycles=1))
    assert numbers(paper.design) == (2.0, 20.0)


def test_max_cycles_bounds_a_search_that_always_improves() -> None:
    measuring = Measuring(lambda morphology, reward: morphology + reward)
    settings = sizes(2, 2, survivors=0.25, max_cycles=4)
    best, *_ = robomore(CountingDesigner(), measuring, settings)
    assert numbers(best.design) == (2.0 + 4, 20.0 + 4)


@pytest.mark.parametrize(("patience", "asked"), [(1, 1), (3, 3), (9, 5)])
def test_patience_lets_a_branch_without_improvement_go_on(patience: int, asked: int) -> None:
    measuring = Measuring(lambda morphology, reward: -morphology - reward)
    settings = sizes(2, 2, survivors=0.25, max_cycles=5, patience=patience)
    robomore(CountingDesigner(), measuring, settings)
    fine = [trial for batch in measuring.batches for trial in batch if trial.place.stage == "fine"]
    assert len(fine) == 2 * asked


def test_an_improvement_gives_a_branch_new_patience() -> None:
    # A first cycle in vain, a second that improves, then as many in vain as it has patience.
    measuring = Measuring(lambda morphology, reward: -abs(morphology - 4) - reward)
    settings = sizes(2, 1, survivors=0.5, max_cycles=9, patience=2)
    robomore(CountingDesigner(step=1), measuring, settings)
    cycles = {
        trial.place.index[1]
        for batch in measuring.batches
        for trial in batch
        if trial.place.stage == "fine"
    }
    # The morphology goes from 2 to 4 in two cycles.
    assert cycles == {0, 1, 2, 3}


def test_the_objective_decides() -> None:
    light = replace(evaluation(design(1, 1), 9.0), fitness=1.0)
    far = replace(evaluation(design(2, 1), 5.0), fitness=7.0)
    assert top([light, far], 0.1, "efficiency") == [light]
    assert top([light, far], 0.1, "fitness") == [far]


def test_the_reference_reward_is_the_first_column_and_may_win() -> None:
    # Nothing proposed is as good as the reference reward, 1.
    measuring = Measuring(lambda morphology, reward: morphology - abs(reward - 1))
    designer = CountingDesigner()
    best, *_ = robomore(designer, measuring, sizes(2, 3, reference_reward="in", max_cycles=0))
    assert numbers(best.design) == (2.0, 1.0)
    assert [numbers(t.design)[1] for t in measuring.batches[0]] == [1, 10, 20] * 2
    assert sum(slot.kind == "reward" for slot in designer.asked) == 2


def test_the_slim_reference_is_the_first_row_and_may_win() -> None:
    slim = thinnest(get_task("swimmer"))
    measuring = Measuring(lambda morphology, reward: -morphology)  # of its first parameter
    designer = CountingDesigner()
    settings = sizes(3, 2, slim_reference="in", max_cycles=0)
    best, *_ = robomore(designer, measuring, settings)
    assert best.design.morphology == slim
    rows = [t.design.morphology.parameters for t in measuring.batches[0]]
    assert rows == [slim.parameters] * 2 + [(1.0,)] * 2 + [(2.0,)] * 2
    assert [t.place.index for t in measuring.batches[0]] == [
        (i, j) for i in range(3) for j in (0, 1)
    ]
    planned = dict(RoboMoRe(settings).plan(context()).proposals)
    assert planned["propose", "morphology"] == 2
    assert sum(slot.kind == "morphology" for slot in designer.asked) == 2


def test_what_stands_in_the_grid_anyway_takes_one_place() -> None:
    slim, own = thinnest(get_task("swimmer")), context().reference.reward

    class Begun(CountingDesigner):
        def propose_morphology(self, slot: Slot, earlier: Sequence[Morphology]) -> Morphology:
            return slim if slot.index == (0,) else super().propose_morphology(slot, earlier)

        def propose_reward(self, slot: Slot, earlier: Sequence[Reward]) -> Reward:
            return own

    measuring = Measuring(lambda morphology, reward: 1.0)
    settings = sizes(3, 2, slim_reference="in", reference_reward="in", max_cycles=0)
    robomore(Begun(), measuring, settings)
    (grid,) = measuring.batches
    assert len({trial.design for trial in grid}) == len(grid) == 2
    assert [trial.design.morphology for trial in grid].count(slim) == 1


def test_without_the_coarse_stage_the_search_begins_at_a_proposed_pair() -> None:
    measuring = Measuring(lambda morphology, reward: 1.0)
    designer = CountingDesigner()
    options = {"slim_reference": "in", "reference_reward": "in", "max_cycles": 0}
    robomore(designer, measuring, sizes(3, 2, **options, without=("coarse",)))
    ((only,),) = measuring.batches
    assert numbers(only.design) == (1.0, 10.0)
    assert [slot.kind for slot in designer.asked] == ["morphology", "reward"]


def test_without_the_morphology_all_rewards_are_tried_on_the_reference() -> None:
    measuring = Measuring(lambda morphology, reward: 1.0)
    designer = CountingDesigner()
    settings = sizes(3, 2, slim_reference="in", max_cycles=0, without=("morphology",))
    robomore(designer, measuring, settings)
    assert {t.design.morphology for t in measuring.batches[0]} == {context().reference.morphology}
    assert all(slot.kind == "reward" for slot in designer.asked)


def test_a_grid_of_the_reference_reward_alone_asks_for_no_reward() -> None:
    measuring = Measuring(lambda morphology, reward: morphology)
    designer = CountingDesigner()
    robomore(designer, measuring, sizes(3, 1, reference_reward="in", max_cycles=0))
    assert {slot.kind for slot in designer.asked} == {"morphology"}


def test_a_refinement_names_the_evaluation_that_it_was_made_from() -> None:
    measuring = Measuring(lambda morphology, reward: -abs(morphology - 3) - abs(reward - 10))
    start = measuring.evaluation_of(design(1, 10))
    fine(CountingDesigner(), measuring, [start], [start], 2, 1, context())
    places = [batch[0].place for batch in measuring.batches]
    better, _, best, _ = (measuring.evaluation_of(b[0].design).key for b in measuring.batches)
    assert [place.parent for place in places] == [start.key, better, better, best]
    assert [place.index for place in places] == [(0, 0), (0, 0), (0, 1), (0, 1)]


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
    measuring = Measuring(lambda morphology, reward: morphology * reward)
    designer = Stubborn("coarse morphology 2", "coarse reward 1")
    grid = coarse(designer, measuring, sizes(3, 3), context())
    (batch,) = measuring.batches
    places = [t.place.index for t in batch]
    assert places == [(0, 1), (0, 2), (2, 1), (2, 2)]
    # Those after it see only what there is.
    assert [numbers(e.design) for e in grid] == [(1, 10), (1, 20), (2, 10), (2, 20)]


@pytest.mark.parametrize("kind", ["morphology", "reward"])
def test_a_grid_without_any_proposal_ends_the_search_and_says_why(kind: str) -> None:
    designer = Stubborn(*(f"coarse {kind} {number}" for number in (1, 2)))
    measuring = Measuring(lambda morphology, reward: 1.0)
    with pytest.raises(NothingTrained, match=f"none of 2 slots for a {kind}.*no coarse {kind} 1"):
        robomore(designer, measuring, sizes(2, 2))
    assert not measuring.batches


def test_a_half_cycle_without_proposal_improves_nothing_and_the_others_go_on() -> None:
    measuring = Measuring(lambda morphology, reward: min(morphology, 4) + min(reward, 12))
    starts = [measuring.evaluation_of(design(morphology, 10)) for morphology in (1, 2)]
    designer = Stubborn("fine morphology 1.1", "fine reward 2.2")
    best = fine(designer, measuring, starts, starts, 10, 1, context())
    assert [numbers(e.design) for e in best] == [(4.0, 12.0), (4.0, 12.0)]
    assert [[t.place.index[0] for t in batch] for batch in measuring.batches[:4]] == [
        [1],
        [0, 1],
        [0, 1],
        [0],
    ]


def test_a_branch_without_any_proposal_keeps_its_best_and_ends() -> None:
    measuring = Measuring(lambda morphology, reward: morphology + reward)
    start = measuring.evaluation_of(design(1, 10))
    designer = Stubborn("fine morphology 1.1", "fine reward 1.1")
    assert fine(designer, measuring, [start], [start], 5, 1, context()) == [start]
    assert not measuring.batches


def test_what_does_not_depend_on_each_other_is_asked_for_together() -> None:
    asked: list[int] = []

    def side_by_side(calls: Sequence[Callable[[], T]], /) -> list[T]:
        asked.append(len(calls))
        return list(reversed([call() for call in reversed(calls)]))

    measuring = Measuring(lambda morphology, reward: morphology + reward)
    settings = sizes(4, 2, survivors=0.25, max_cycles=1)
    reflecting = CountingDesigner()
    turns = robomore(reflecting, measuring, settings)
    assert robomore(reflecting, measuring, settings, map_fn=side_by_side) == turns
    # Diversity Reflection goes in order; the two branches do not.
    assert asked == [2, 2]
    asked.clear()
    blind = CountingDesigner()
    blind.reflects = False
    robomore(blind, measuring, settings, map_fn=side_by_side)
    assert asked == [4, 2, 2, 2]
    assert [slot.index for slot in blind.asked[:4]] == [(3,), (2,), (1,), (0,)]


def test_random_morphologies_meet_the_rewards_of_the_designer() -> None:
    designer, measuring = CountingDesigner(), Measuring(lambda morphology, reward: reward)
    settings = sizes(4, 2, max_cycles=0, first_morphologies="gaussian")
    robomore(designer, measuring, settings)
    (grid,) = measuring.batches
    morphologies = {trial.design.morphology.parameters for trial in grid}
    swimmer = get_task("swimmer").searched()
    assert len(grid) == 8 and len(morphologies) == 4
    assert all(swimmer.check(parameters) for parameters in morphologies)
    assert {slot.kind for slot in designer.asked} == {"reward"} and len(designer.asked) == 2
    again = Measuring(lambda morphology, reward: reward)
    robomore(CountingDesigner(), again, settings)
    assert again.batches == measuring.batches
    assert "drawn around the reference" in RoboMoRe(settings).adds
    with pytest.raises(InputError, match="leave one of them out"):
        RoboMoRe(replace(settings, without=("morphology",)))


def test_what_no_designer_proposed_is_said() -> None:
    settings = RoboMoReSettings(slim_reference="in")
    assert RoboMoRe(settings).adds == (
        "The grid also has the reference morphology, as thin as its search rules allow, and the "
        "reference reward."
    )
    assert "thin" not in RoboMoRe(RoboMoReSettings()).adds
    assert "thin" not in RoboMoRe(replace(settings, without=("morphology",))).adds
    assert RoboMoRe(RoboMoReSettings(reference_reward="out")).adds == ""
