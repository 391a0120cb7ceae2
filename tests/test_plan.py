"""Plans: what a place is called, and in which order places stand."""

from __future__ import annotations

from robomore.plan import Plan, Stage
from robomore.types import Place

PLAN = Plan(
    (
        Stage(
            name="grid",
            axes=("morphology", "reward"),
            shape=(3, 2),
            proposals=(("propose", "morphology", 3), ("propose", "reward", 2)),
        ),
        Stage(
            name="climb",
            axes=("branch", "cycle"),
            proposals=(("improve", "reward", 4), ("propose", "reward", 1)),
        ),
        Stage(name="last", axes=("finalist",), shape=(1,), role="final"),
    )
)


def test_places_in_words() -> None:
    assert PLAN.describe(Place(stage="grid", index=(2, 0))) == "grid: morphology 3, reward 1"
    said = PLAN.describe(Place(stage="climb", index=(0, 1), changed="reward"))
    assert said == "climb: branch 1, cycle 2, new reward"
    place = Place(stage="last", index=(0,), changed="reference", repeat=2)
    assert PLAN.describe(place) == "last: reference, training seed 2"
    assert PLAN.describe(Place(stage="unheard of", index=(4,))) == "unheard of: number 5"
    assert PLAN.describe(Place(stage="unheard of")) == "unheard of"


def test_places_stand_in_the_order_of_the_search() -> None:
    places = [
        Place(stage="grid", index=(0, 1)),
        Place(stage="grid", index=(1, 0)),
        Place(stage="climb", index=(0, 0), changed="morphology"),
        Place(stage="climb", index=(0, 0), changed="reward"),
        Place(stage="last", index=(0,), changed="found", repeat=1),
        Place(stage="last", index=(0,), changed="found", repeat=2),
        Place(stage="unheard of"),
    ]
    shuffled = places[3:] + places[:3]
    assert sorted(shuffled, key=PLAN.position) == places


def test_proposals_are_summed_over_stages_and_grids_are_known() -> None:
    assert PLAN.proposals["propose", "reward"] == 3
    assert PLAN.proposals["improve", "morphology"] == 0
    assert [stage.is_grid for stage in PLAN.stages] == [True, False, False]
