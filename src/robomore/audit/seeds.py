"""Does the robot do in other episodes what the run tells?"""

from __future__ import annotations

from robomore.audit.subject import Subject
from robomore.runs.words import in_unit, number
from robomore.store.audit import Outcome, Verdict

REPORTED = "reported"
"""Name of the number that the run tells."""

FAILS_BELOW, WARNS_BELOW = 0.5, 0.8
"""Fractions of the fitness that the run tells. Episodes differ by their start, and a mean of ten of
them is off by a few per cent; half of it is another robot, another policy, or a number that is not
the run's."""


def check(subject: Subject) -> Verdict:
    """Measure in episodes that no measurement of a run uses."""
    name = "other seeds"
    found, worth = subject.measured(), subject.worth()
    if found is None or worth is None:
        return Verdict(name, "fails", "In episodes with other seeds the physics diverges.")
    low, high = min(found.episode_fitness), max(found.episode_fitness)
    said = (
        f"{_told(found.fitness, subject)} in {len(found.episode_fitness)} other episodes "
        f"({number(low)} to {_told(high, subject)})"
    )
    numbers = {"fitness": found.fitness, "lowest": low, "highest": high}
    if subject.reported is None:
        return Verdict(name, "skipped", f"{said}; nothing tells a number to compare.", numbers)
    numbers[REPORTED] = subject.reported
    said += f"; the run tells {_told(subject.reported, subject)}"
    at_rest = found.fitness - worth
    if at_rest:
        said += f"; {_told(at_rest, subject)} of each are its height at rest"
    reported = subject.reported - at_rest
    share = worth / reported if reported > 0 else 1.0
    outcome: Outcome = (
        "fails" if share < FAILS_BELOW else "warns" if share < WARNS_BELOW else "passes"
    )
    return Verdict(name, outcome, f"{said}.", numbers)


def _told(value: float, subject: Subject) -> str:
    return in_unit(value, "fitness", subject.unit)
