"""Does the robot's energy come from its motors?"""

from __future__ import annotations

from robomore.audit.retained import LEAST_WORTH
from robomore.audit.subject import Subject
from robomore.audit.variant import Variant
from robomore.runs.words import in_unit, number
from robomore.store.audit import Outcome, Verdict
from robomore.transport import GRAVITY

MOST_CREATED = 0.05
"""Most energy from nowhere, as a fraction of what the motors do. Contacts and joint limits take
energy, so that an honest robot is below zero; the balance itself is exact to about 1 %."""
STARTED_FAILS_ABOVE, STARTED_WARNS_ABOVE = 0.5, 0.1
"""Fractions of what the robot does that it does without its motors, where contacts and joint limits
push it out of a bad start. The official Ant starts with 1.2 kJ in its ankles' limits, and
gets nowhere by them."""
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
        "sprung_j": seen.sprung,
        "created_j": seen.created,
        "created_share": share,
    }
    told = (
        f"The motors gave {number(seen.motor_work)} J; {number(seen.dissipated)} J went into "
        f"damping and fluid, and {number(seen.stored)} J are stored at the end"
    )
    outcome: Outcome = "passes"
    if seen.sprung > MOST_CREATED * lift:
        told += f"; contacts and joint limits held {number(seen.sprung)} J at the start"
        outcome, without = _started(subject)
        if without is not None:
            numbers["without_motors"] = without
            told += f", which alone make {in_unit(without, 'fitness', subject.unit)}"
    if share > MOST_CREATED:
        outcome = "fails"
        rest = f". {number(seen.created)} J came from nowhere: contacts or the integrator gave them"
    else:
        rest = f"; contacts and joint limits took the other {number(max(0.0, -seen.created))} J"
    return Verdict("energy balance", outcome, f"{told}{rest}.", numbers)


def _started(subject: Subject) -> tuple[Outcome, float | None]:
    """Return a verdict on how a robot starts, and what it is worth without its motors.

    Only of a goal that is motion: what stands still may be worth something by another.
    """
    base = subject.worth()
    if base is None or base < LEAST_WORTH or subject.task.goal.motion == "other":
        return "passes", None
    without = subject.worth(Variant(motors=0.0))
    share = (without or 0.0) / base
    if share > STARTED_FAILS_ABOVE:
        return "fails", without
    return "warns" if share > STARTED_WARNS_ABOVE else "passes", without
