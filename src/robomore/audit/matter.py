"""Does the robot do the same when mass, friction and motors are not what they were said to be?"""

from __future__ import annotations

from robomore.audit.retained import retained
from robomore.audit.subject import Subject
from robomore.audit.variant import Variant
from robomore.store.audit import Verdict

CHANGE = 0.2
"""As a fraction. Real parts differ from their drawing by some of it, and frictions by more."""
WARNS_BELOW = 0.5
"""Fraction of the distance that is left. The policy knows one robot only, so it never fails."""


def check(subject: Subject) -> Verdict:
    """Change mass, friction and motor strength, each up and down, one at a time."""
    variants: dict[str, Variant] = {}
    for sign, factor in (("-", 1 - CHANGE), ("+", 1 + CHANGE)):
        much = f"{sign}{100 * CHANGE:.0f} %"
        variants[f"{much} mass"] = Variant(mass=factor)
        if subject.has_ground:
            variants[f"{much} friction"] = Variant(friction=factor)
        variants[f"{much} motor strength"] = Variant(motors=factor)
    return retained(subject, "mass, friction and motor strength", variants, warns_below=WARNS_BELOW)
