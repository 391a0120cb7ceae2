"""Does the robot's energy come from its motors?"""

from __future__ import annotations

from robomore.audit.subject import Subject
from robomore.runs.words import number
from robomore.store.audit import Verdict
from robomore.types import GRAVITY

MOST_CREATED = 0.05
"""Most energy from nowhere, as a fraction of what the motors do. Contacts and joint limits take
energy, so that an honest robot is below zero; the balance itself is exact to about 1 %."""
_LIFT = 1.0
"""Metres. A robot whose motors do nothing may still gain this fraction of what lifts it so far:
it starts with noise, a little inside the ground."""


def check(subject: Subject) -> Verdict:
    """Compare what the robot stores and loses to damping and fluid with what its motors gave."""
    seen = subject.inspection
    if seen is None or seen.divergences:
        return Verdict("energy balance", "fails", "The physics diverges.")
    lift = subject.facts["mass"] * GRAVITY * _LIFT
    share = seen.created / (seen.motor_effort + lift)
    numbers = {
        "motor_work_j": seen.motor_work,
        "motor_effort_j": seen.motor_effort,
        "dissipated_j": seen.dissipated,
        "stored_j": seen.stored,
        "created_j": seen.created,
        "created_share": share,
    }
    told = (
        f"The motors gave {number(seen.motor_work)} J; {number(seen.dissipated)} J went into "
        f"damping and fluid, and {number(seen.stored)} J are stored at the end"
    )
    if share > MOST_CREATED:
        came = f"{number(seen.created)} J came from nowhere: contacts or the integrator gave them"
        return Verdict("energy balance", "fails", f"{told}. {came}.", numbers)
    rest = f"contacts and joint limits took the other {number(max(0.0, -seen.created))} J"
    return Verdict("energy balance", "passes", f"{told}; {rest}.", numbers)
