"""From which number on a check warns and fails: those that docs/audit.md tells."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from audit.planted import restless, short, still
from robomore.audit import (
    Subject,
    Variant,
    Verdict,
    energy,
    integrator,
    matter,
    motors,
    noise,
    penetration,
    pushes,
    saturation,
    seeds,
    self_collision,
    support,
    timestep,
)
from robomore.audit import density as density_check
from robomore.transport import GRAVITY

Check = Callable[[Subject], Verdict]
P, W, F = "passes", "warns", "fails"


def left(share: float) -> Subject:
    """Return a robot of which any change leaves `share` of the fitness."""
    subject = restless(short("half-cheetah", 5))
    found = replace(subject.measured(), fitness=10.0)  # type: ignore[type-var]
    subject._measured = Everything({Variant(): found}, replace(found, fitness=10 * share))  # type: ignore[assignment]
    return subject


class Everything(dict[Variant, Any]):
    """Measurements of all variants there are: all but those given have one and the same."""

    def __init__(self, known: dict[Variant, Any], other: Any) -> None:
        """Keep the known ones, and what any other one is."""
        super().__init__(known)
        self.other = other

    def __contains__(self, key: object) -> bool:
        """Say that any variant was measured."""
        return True

    def __missing__(self, key: Variant) -> Any:
        """Return what an unknown one is."""
        return self.other


@pytest.mark.parametrize(
    ("check", "share", "outcome"),
    [
        (timestep.check, 0.76, P),
        (timestep.check, 0.74, W),
        (timestep.check, 0.51, W),
        (timestep.check, 0.49, F),
        (timestep.check, 1.99, P),
        (timestep.check, 2.01, W),
        (integrator.check, 0.71, P),
        (integrator.check, 0.69, W),
        (integrator.check, 0.51, W),
        (integrator.check, 0.49, F),
        (integrator.check, 2.01, W),
        *[
            (check, share, outcome)
            for check in (noise.check, pushes.check, matter.check)
            for share, outcome in ((0.51, P), (0.49, W), (0.0, W), (-1.0, W), (9.0, P))
        ],
    ],
)
def test_of_the_distance_that_is_left(check: Check, share: float, outcome: str) -> None:
    assert check(left(share)).outcome == outcome


@pytest.mark.parametrize(("fitness", "skipped"), [(0.099, True), (0.101, False)])
def test_of_a_distance_that_counts(fitness: float, skipped: bool) -> None:
    subject = left(1.0)
    subject._measured[Variant()] = replace(subject._measured[Variant()], fitness=fitness)  # type: ignore[type-var]
    assert (timestep.check(subject).outcome == "skipped") == skipped


@pytest.mark.parametrize(
    ("reported", "outcome"), [(12.4, P), (12.6, W), (19.9, W), (20.1, F), (1.0, P)]
)
def test_of_what_the_run_tells(reported: float, outcome: str) -> None:
    assert seeds.check(replace_reported(left(1.0), reported)).outcome == outcome


def replace_reported(subject: Subject, reported: float) -> Subject:
    """Return the subject of a run that tells `reported`."""
    subject.reported = reported
    return subject


@pytest.mark.parametrize(
    ("check", "seen", "outcome"),
    [
        (penetration.check, {"deep_share": 0.049}, P),
        (penetration.check, {"deep_share": 0.051}, W),
        (penetration.check, {"deep_share": 0.099}, W),
        (penetration.check, {"deep_share": 0.101}, F),
        (self_collision.check, {"overlap_share": 0.049}, P),
        (self_collision.check, {"overlap_share": 0.051}, W),
        (self_collision.check, {"overlap_share": 1.0}, W),
        (support.check, {"support": {"head": 0.05, "torso": 0.049, "bfoot": 0.901}}, P),
        (support.check, {"support": {"head": 0.05, "torso": 0.051, "bfoot": 0.899}}, W),
    ],
)
def test_of_what_is_seen(check: Check, seen: dict[str, Any], outcome: str) -> None:
    assert check(looked_into(seen)).outcome == outcome


def looked_into(seen: dict[str, Any]) -> Subject:
    """Return a robot in which `seen` is seen."""
    subject = still(short("half-cheetah", 5))
    found = replace(subject.inspection, **seen)  # type: ignore[type-var]
    object.__setattr__(subject, "inspection", found)
    return subject


@pytest.mark.parametrize(("share", "outcome"), [(0.049, P), (0.051, F), (-3.0, P)])
def test_of_energy_from_nowhere(share: float, outcome: str) -> None:
    """It is told over what the motors did and what lifts the robot by a metre."""
    effort = 1000.0
    lift = still(short("half-cheetah", 5)).facts["mass"] * GRAVITY
    created = share * (effort + lift)
    energies = {"motor_work": 900.0, "motor_effort": effort, "dissipated": 800.0, "sprung": 0.0}
    stored = 900.0 - 800.0 + created
    verdict = energy.check(looked_into({**energies, "stored": stored}))
    assert verdict.outcome == outcome
    assert verdict.numbers["created_share"] == pytest.approx(share)


@pytest.mark.parametrize(
    ("without_motors", "sprung", "outcome"),
    [
        (0.09, 1e4, P),
        (0.11, 1e4, W),
        (0.49, 1e4, W),
        (0.51, 1e4, F),
        (0.51, 1.0, P),
        (-1.0, 1e4, P),
    ],
)
def test_of_a_start(without_motors: float, sprung: float, outcome: str) -> None:
    subject = left(without_motors)
    seen = replace(subject.inspection, sprung=sprung)  # type: ignore[type-var]
    object.__setattr__(subject, "inspection", seen)
    verdict = energy.check(subject)
    assert verdict.outcome == outcome and verdict.numbers["sprung_j"] == sprung


@pytest.mark.parametrize(("share", "outcome"), [(0.89, P), (0.91, W)])
def test_of_actions_at_their_limit(share: float, outcome: str) -> None:
    subject = left(1.0)
    plain = subject._measured[Variant()]
    behaviour = {**plain.behaviour, "saturated_share": share}  # type: ignore[union-attr]
    subject._measured[Variant()] = replace(plain, behaviour=behaviour)  # type: ignore[type-var]
    assert saturation.check(subject).outcome == outcome


@pytest.mark.parametrize(
    ("density", "outcome"), [(7_840.0, P), (7_860.0, W), (22_580.0, W), (22_600.0, F)]
)
def test_of_matter(density: float, outcome: str) -> None:
    subject = still(short("half-cheetah", 5))
    facts = {**subject.facts, "density": density}
    object.__setattr__(subject, "facts", facts)
    assert density_check.check(subject).outcome == outcome


@pytest.mark.parametrize(("times", "outcome"), [(9.9, P), (10.1, W)])
def test_of_motors(times: float, outcome: str, monkeypatch: pytest.MonkeyPatch) -> None:
    subject = still(short("half-cheetah", 5))
    subject.parameters = tuple(1.01 * one for one in subject.parameters)
    own = {subject.parameters: times, subject.task.reference: 1.0}
    monkeypatch.setattr(motors, "_strength", lambda _, which: (30.0, own[which]))
    assert motors.check(subject).outcome == outcome
