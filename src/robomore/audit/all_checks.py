"""All checks of one subject, in the order in which they are told."""

from __future__ import annotations

from collections.abc import Callable

from robomore.audit import (
    bounds,
    density,
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
from robomore.audit.subject import Subject
from robomore.envs.silent import silent_mujoco
from robomore.store.audit import Audit, Verdict
from robomore.store.manifest import package_versions

Check = Callable[[Subject], Verdict]

CHECKS: tuple[Check, ...] = (
    seeds.check,
    timestep.check,
    integrator.check,
    energy.check,
    penetration.check,
    density.check,
    self_collision.check,
    support.check,
    motors.check,
    bounds.check,
    saturation.check,
    noise.check,
    pushes.check,
    matter.check,
)
"""First what can fail a design, then what can only warn."""


def audit(subject: Subject) -> Audit:
    """Return the verdicts of all checks on `subject`. The policy runs; nothing is trained.

    The same subject gives the same audit. It takes about twenty times as long as one measurement.
    """
    # What diverges under another integrator is told by that check.
    with silent_mujoco():
        found = subject.measured()
        equal_density = density.equal_density(subject)
        verdicts = tuple(check(subject) for check in CHECKS)
    volume = subject.facts["volume"]
    return Audit(
        task=subject.task.id,
        policy=subject.policy.digest,
        episodes=subject.episodes,
        fitness=found.fitness if found else None,
        volume=volume,
        efficiency=found.fitness / volume if found else None,
        equal_density=equal_density,
        verdicts=verdicts,
        versions=package_versions(),
    )
