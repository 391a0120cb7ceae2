"""Does the robot do the same at half the timestep?"""

from __future__ import annotations

from robomore.audit.retained import NUMERICAL_GAIN, retained
from robomore.audit.subject import Subject
from robomore.audit.variant import Variant
from robomore.store.audit import Verdict

FAILS_BELOW, WARNS_BELOW = 0.5, 0.75
"""Fractions of the distance that are left. Physics is what is left when the timestep goes to zero.
A policy was trained at one timestep and may lose some; the five human designs keep 89 % or more."""


def check(subject: Subject) -> Verdict:
    """Run at half the timestep; the control step stays what it is."""
    return retained(
        subject,
        "half the timestep",
        {"half the timestep": Variant(timestep_division=2)},
        fails_below=FAILS_BELOW,
        warns_below=WARNS_BELOW,
        warns_above=NUMERICAL_GAIN,
    )
