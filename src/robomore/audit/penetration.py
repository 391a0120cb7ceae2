"""Do the robot's limbs stay above the ground?"""

from __future__ import annotations

from robomore.audit.subject import Subject
from robomore.runs.words import number
from robomore.store.audit import Outcome, Verdict

FAILS_ABOVE, WARNS_ABOVE = 0.1, 0.05
"""Fractions of the time in which some limb is deeper than its radius, so that its middle line is
below the surface. Contacts are soft, and the official robots' feet are as deep in hard landings:
Half-Cheetah's for 0.2 % of the time, Hopper's for 5.5 %."""


def check(subject: Subject) -> Verdict:
    """Look how deep each limb goes, in units of its own radius."""
    seen = subject.inspection
    if seen is None:
        return Verdict("penetration", "fails", "The physics diverges.")
    if not seen.has_ground:
        return Verdict("penetration", "skipped", "Nothing in this task touches a ground.")
    if seen.divergences:
        return Verdict("penetration", "fails", "The physics diverges.")
    part, depth = max(seen.depths.items(), key=lambda one: one[1])
    outcome: Outcome = "passes"
    if seen.deep_share > FAILS_ABOVE:
        outcome = "fails"
    elif seen.deep_share > WARNS_ABOVE:
        outcome = "warns"
    said = "No limb goes into the ground."
    if depth > 0:
        said = (
            f"{part} goes {number(depth, 2)} radii into the ground at most; some limb is deeper "
            f"than its own radius for {100 * seen.deep_share:.1f} % of the time. What touches the "
            f"ground is {1000 * seen.usual_depth:.0f} mm deep in the median."
        )
    return Verdict(
        "penetration",
        outcome,
        said,
        {
            "deepest_radii": depth,
            "deep_share": seen.deep_share,
            "usual_depth_m": seen.usual_depth,
        },
    )
