"""Eureka's rounds: what each one improves on, and what it may know."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from robomore.designers.started import StartedDesigner
from robomore.errors import NothingTrained, ProposalFailed
from robomore.search import make_method
from robomore.tasks import get_task
from robomore.testing.methods import check_method
from robomore.types import Evaluation, MethodSettings, Reward, Slot
from search.fakes import CountingDesigner, Measuring, context

NAMES = ("eureka", "eureka-morphology")


@pytest.mark.parametrize("name", NAMES)
def test_it_keeps_the_contract(name: str) -> None:
    method = MethodSettings(name, {"iterations": 2})
    check_method(lambda: make_method(method), get_task("swimmer"), 4)


class Numbered(CountingDesigner):
    """Rewards by their slot: 10 for the first, 11 for the second; later ones add their number."""

    def propose_reward(self, slot: Slot, earlier: Sequence[Reward]) -> Reward:
        assert not earlier, "the proposals of a round do not know of each other"
        return Reward(str(10.0 + slot.index[1]))

    def improve_reward(self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]) -> Reward:
        assert slot.improves and list(history) == [best]
        return Reward(str(float(best.design.reward.source) + slot.index[1]))


def test_each_round_improves_on_the_best_of_the_one_before() -> None:
    measuring = Measuring(lambda morphology, reward: reward)
    method = make_method(MethodSettings("eureka", {"iterations": 3, "samples": 4}))
    best = method.run(Numbered(), measuring, context())
    assert [len(batch) for batch in measuring.batches] == [4, 4, 4]
    assert {t.design.morphology for batch in measuring.batches for t in batch} == {
        context().reference.morphology
    }
    # 13 is the best of 10 to 13, then 13 + 3, then 16 + 3.
    assert best[0].efficiency == 19
    first, second, third = measuring.batches
    keys = {e.efficiency: e.key for e in best}
    assert [t.place.parent for t in second] == [keys[13.0]] * 4
    assert [t.place.parent for t in third] == [keys[16.0]] * 4
    assert not any(t.place.parent for t in first)


def test_a_round_of_failures_is_skipped() -> None:
    def score(morphology: float, reward: float) -> float | None:
        return None if reward > 13 else reward

    method = make_method(MethodSettings("eureka", {"iterations": 3, "samples": 4}))
    measuring = Measuring(score)
    best = method.run(Numbered(), measuring, context())
    assert best[0].efficiency == 13 and len(measuring.batches) == 3


def test_after_a_first_round_of_failures_the_next_one_proposes_anew() -> None:
    method = make_method(MethodSettings("eureka", {"iterations": 3, "samples": 4}))
    measuring = Measuring(lambda morphology, reward: reward if reward >= 14 else None)
    designer = StartedDesigner(Numbered(), (), [Reward("1")])
    best = method.run(designer, measuring, context())
    rewards = [[float(t.design.reward.source) for t in batch] for batch in measuring.batches]
    # What was given stands in the first round alone; 17 is the best of 14 to 17, then 17 + 3.
    assert rewards == [[1, 11, 12, 13], [14, 15, 16, 17], [17, 18, 19, 20]]
    assert best[0].efficiency == 20
    assert [t.place.index for t in measuring.batches[1]] == [(1, n) for n in range(4)]
    assert not any(t.place.parent for t in measuring.batches[1])


def test_rounds_in_which_all_fail_end_with_why() -> None:
    method = make_method(MethodSettings("eureka", {"iterations": 3, "samples": 4}))
    with pytest.raises(NothingTrained, match="all 12 candidates failed"):
        method.run(Numbered(), Measuring(lambda morphology, reward: None), context())


def test_an_empty_slot_costs_nothing() -> None:
    class Poor(Numbered):
        def propose_reward(self, slot: Slot, earlier: Sequence[Reward]) -> Reward:
            if slot.index[1]:
                raise ProposalFailed("no idea")
            return super().propose_reward(slot, earlier)

        def improve_reward(
            self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]
        ) -> Reward:
            raise ProposalFailed("no idea")

    measuring = Measuring(lambda morphology, reward: reward)
    method = make_method(MethodSettings("eureka", {"iterations": 3, "samples": 4}))
    assert [e.efficiency for e in method.run(Poor(), measuring, context())] == [10]
    assert [len(batch) for batch in measuring.batches] == [1]
