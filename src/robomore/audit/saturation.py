"""Does the policy steer, or do the motors' limits?"""

from __future__ import annotations

from robomore.audit.subject import Subject
from robomore.store.audit import Verdict

WARNS_ABOVE = 0.9
"""Fraction of all actions that are at their limit. Some tasks are best done with full force; a
policy that never uses less does not depend on what it sees, and breaks gears."""


def check(subject: Subject) -> Verdict:
    """Count the actions at their limit."""
    found = subject.measured()
    if found is None:
        return Verdict("saturation of actions", "fails", "The physics diverges.")
    share = found.behaviour["saturated_share"]
    return Verdict(
        "saturation of actions",
        "warns" if share > WARNS_ABOVE else "passes",
        f"{100 * share:.0f} % of all actions are at their limit.",
        {"saturated_share": share},
    )
