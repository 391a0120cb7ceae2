"""The paper's method without one of its parts."""

from __future__ import annotations

import pytest

from robomore.errors import InputError
from robomore.search.robomore import RoboMoRe, RoboMoReSettings
from robomore.settings import from_options
from robomore.tasks import get_task
from robomore.testing.methods import check_method
from robomore.types import Design, Morphology, Reward, Trial
from search.fakes import CountingDesigner, Measuring, context, robomore, sizes


def tried(measuring: Measuring) -> list[Trial]:
    return [trial for batch in measuring.batches for trial in batch]


def searched(*without: str) -> tuple[CountingDesigner, list[Trial]]:
    designer, measuring = (
        CountingDesigner(),
        Measuring(lambda morphology, reward: morphology + reward),
    )
    settings = sizes(3, 2, without=without, max_cycles=2, survivors=0.2)
    robomore(designer, measuring, settings)
    return designer, tried(measuring)


def test_without_fine_nothing_is_improved() -> None:
    designer, trials = searched("fine")
    assert len(trials) == 6 and not any(slot.improves for slot in designer.asked)


def test_without_coarse_the_search_starts_from_one_pair() -> None:
    _, trials = searched("coarse")
    assert len([t for t in trials if t.place.stage == "coarse"]) == 1
    assert len([t for t in trials if t.place.stage == "fine"]) == 4


def test_without_morphology_all_designs_have_the_reference_s() -> None:
    designer, trials = searched("morphology")
    assert {t.design.morphology for t in trials} == {context().reference.morphology}
    assert {slot.kind for slot in designer.asked} == {"reward"}
    assert len({t.design.reward for t in trials}) > 2


def test_without_reward_all_designs_have_the_reference_s() -> None:
    designer, trials = searched("reward")
    assert {t.design.reward for t in trials} == {context().reference.reward}
    assert {slot.kind for slot in designer.asked} == {"morphology"}
    assert len([t for t in trials if t.place.stage == "coarse"]) == 3


def test_without_diversity_no_proposal_sees_another() -> None:
    _, trials = searched("diversity", "fine")
    # The designer counts on from what it is shown, so it repeats itself.
    assert {t.design for t in trials} == {Design(Morphology((1.0,)), Reward("10"))}


@pytest.mark.parametrize("part", ["diversity", "reward"])
def test_an_ablation_keeps_the_contract(part: str) -> None:
    options = {"morphologies": 3, "rewards": 2, "max_cycles": 1, "without": [part]}
    settings = from_options(RoboMoReSettings, options, "method robomore")
    check_method(lambda: RoboMoRe(settings), get_task("swimmer"))


def test_a_search_without_anything_to_search_is_refused() -> None:
    with pytest.raises(InputError, match="leaves nothing to search"):
        RoboMoRe(RoboMoReSettings(without=("morphology", "reward")))
    with pytest.raises(InputError, match="without"):
        from_options(RoboMoReSettings, {"without": ["reflection"]}, "method robomore")
