"""Planted cheats are caught by the check that is for them, and honest robots pass it."""

from __future__ import annotations

import pytest

from audit.planted import bouncy_ground, restless, short, still, through_the_floor
from robomore.audit import Subject, energy, penetration, timestep

ANT_CHEAT = "0.004 0.1"
"""A contact that is stiffer than the timestep can follow, and hardly damped."""


@pytest.mark.parametrize(
    ("task", "solref"),
    [("ant", ANT_CHEAT), ("half-cheetah", "-4000 0")],
    ids=["too stiff for the timestep", "without damping"],
)
def test_energy_from_a_bad_contact_setting(task: str, solref: str) -> None:
    cheat = energy.check(still(bouncy_ground(short(task), solref)))
    assert cheat.outcome == "fails" and "came from nowhere" in cheat.says
    assert cheat.numbers["motor_work_j"] == 0 and cheat.numbers["created_j"] > 100
    assert energy.check(still(short(task))).outcome == "passes"
    assert energy.check(restless(short(task))).outcome == "passes"


def test_a_win_at_one_timestep_only() -> None:
    cheat = timestep.check(still(bouncy_ground(short("ant"), ANT_CHEAT)))
    assert cheat.outcome == "fails"
    assert cheat.numbers["half_the_timestep"] < 0.5 * cheat.numbers["base"]


def test_a_limb_through_the_floor() -> None:
    task = short("half-cheetah", 30)
    cheat = penetration.check(still(through_the_floor(task)))
    assert cheat.outcome == "fails" and "foot goes" in cheat.says
    assert cheat.numbers["deepest_radii"] > 2 and cheat.numbers["deep_share"] > 0.5
    assert cheat.numbers["usual_depth_m"] > 0.046  # the radius of its limbs
    stands = penetration.check(still(task))
    assert stands.outcome == "passes" and 0 < stands.numbers["usual_depth_m"] < 0.02


def test_a_physics_that_diverges_fails() -> None:
    task = bouncy_ground(short("half-cheetah"), ANT_CHEAT)
    subject: Subject = still(task)
    assert energy.check(subject).outcome == penetration.check(subject).outcome == "fails"
