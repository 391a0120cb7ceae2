"""Do limbs pass through each other, where the task switches their collision off?"""

from __future__ import annotations

from robomore.audit.overlap import LEAST_DEPTH
from robomore.audit.subject import Subject
from robomore.store.audit import Verdict

WARNS_ABOVE = 0.05
"""Fraction of the time in which two limbs overlap. The task allows it, so it never fails; no such
robot could be built."""


def check(subject: Subject) -> Verdict:
    """Look how often parts overlap that are not joined to each other."""
    name = "self-collision"
    seen = subject.inspection
    if seen is None:
        return Verdict(name, "fails", "The physics diverges.")
    if not seen.overlap_is_off:
        return Verdict(name, "skipped", "The task lets its parts collide with each other.")
    share = seen.overlap_share
    said = f"Parts overlap by {LEAST_DEPTH:g} radii or more for {100 * share:.1f} % of the time"
    if seen.overlapping:
        said += f", most often {' and '.join(seen.overlapping)}"
    numbers = {"overlap_share": share}
    return Verdict(name, "warns" if share > WARNS_ABOVE else "passes", f"{said}.", numbers)
