"""What an evaluation is compared by."""

from __future__ import annotations

from dataclasses import replace

import pytest

from robomore.types import Design, Evaluation, Job, Morphology, Reward, Status, TrainerSettings

JOB = Job("ant", Design(Morphology((1.0,)), Reward("")), TrainerSettings(), 1, 1, 0)
MOVED = Evaluation(
    "key",
    JOB,
    Status.OK,
    fitness=10.0,
    volume=0.5,
    efficiency=20.0,
    body={"mass": 2.0},
    behaviour={"forward_distance_m": 10.0, "energy_j": 98.1},
)


def test_transport_economy_is_one_over_the_cost_of_transport() -> None:
    assert MOVED.cost_of_transport == pytest.approx(0.5)
    assert MOVED.score("transport-economy") == pytest.approx(2.0)
    assert (MOVED.score(), MOVED.score("fitness"), MOVED.energy) == (20.0, 10.0, 98.1)


@pytest.mark.parametrize(
    ("distance", "height", "counts"),
    [
        (0.4, 0.1, False),
        (1.02, 1.25, False),
        (2.01, 2.45, False),
        (1.02, 0.4, True),
        (3, 1.2, True),
    ],
)
def test_who_only_falls_over_transports_nothing(
    distance: float, height: float, counts: bool
) -> None:
    moved = replace(
        MOVED,
        body={"mass": 2.0, "rest_height": height},
        behaviour={"forward_distance_m": distance, "energy_j": 1.7},
    )
    assert (moved.cost_of_transport is not None) == counts
    assert ((moved.score("transport-economy") or 0) > 0) == counts


@pytest.mark.parametrize("energy", [0.0, 1e-6])
def test_no_fault_of_the_simulation_makes_transport_cheaper_than_the_least(energy: float) -> None:
    thrown = replace(MOVED, behaviour={"forward_distance_m": 10.0, "energy_j": energy})
    assert thrown.score("transport-economy") == pytest.approx(1000)


def test_what_was_not_measured_is_not_compared() -> None:
    assert replace(MOVED, behaviour={}).score("transport-economy") is None
    assert replace(MOVED, status=Status.UNSTABLE).score("transport-economy") is None


def test_names_of_values_are_one_line() -> None:
    with pytest.raises(ValueError, match="one line"):
        replace(MOVED, behaviour={"speed\n# Results": 1.0})
