"""Planted cheats are caught by the check that is for them, and honest robots pass it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from audit.planted import bouncy_ground, restless, short, still, through_the_floor
from robomore.audit import Subject, energy, motors, penetration, timestep

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


def test_a_jump_out_of_the_ground() -> None:
    """A torso larger than it stands high starts inside the ground, which throws it up."""
    task = short("ant-jump", 60)
    large = task.check({**task.named(task.reference), "torso_radius": 1.0})
    cheat = energy.check(replace(restless(task), parameters=large))
    assert cheat.outcome == "fails" and "J at the start, which alone make" in cheat.says
    assert cheat.numbers["without_motors"] > 2 and cheat.numbers["sprung_j"] > 3000
    # The official Ant starts with energy in its ankles' limits, which brings it nowhere.
    honest = energy.check(restless(short("ant")))
    assert honest.outcome == "passes" and honest.numbers["sprung_j"] > 1000
    assert honest.numbers["without_motors"] < 0.1


def test_a_motor_that_pushes_a_site_works() -> None:
    task = short("half-cheetah", 40)
    template = task.template.replace(
        'joint="ffoot" gear="30"', 'site="push" gear="0 0 300 0 0 400"'
    )
    template = template.replace('<geom name="torso"', '<site name="push"/><geom name="torso"', 1)
    flying = still(replace(task, template=template))
    full = np.array([0, 0, 0, 0, 0, 9], np.float32)
    flying.policy = replace(flying.policy, biases=(full,))
    verdict = energy.check(flying)
    assert verdict.outcome == "passes" and verdict.numbers["motor_work_j"] > 100
    assert motors.check(flying).numbers["torque_nm"] == 500.0


def test_a_win_at_one_timestep_only() -> None:
    cheat = timestep.check(still(bouncy_ground(short("ant-jump", 10), ANT_CHEAT)))
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
